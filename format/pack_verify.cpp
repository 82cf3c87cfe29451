#include "format/pack_verify.h"

#include <algorithm>
#include <atomic>
#include <cassert>
#include <optional>
#include <thread>
#include <utility>

#include "cairn/pack_reader.h"
#include "format/object_rules.h"
#include "format/pack_rules.h"
#include "format/rqt_rules.h"

namespace cairn {
namespace {

/// What the threads share: read-only but for the atomics and each thread's own slots.
struct Verification {
  const PackReader& pack;
  std::size_t most_findings;
  std::vector<std::optional<TileDigest>> digests;  // by index; of the height tiles that decode
  std::atomic<std::size_t> next = 0;
  std::atomic<std::size_t> found = 0;

  bool enough() const { return found.load(std::memory_order_relaxed) >= most_findings; }
};

using IndexedFindings = std::vector<std::pair<std::size_t, Finding>>;
using Rule = void (*)(Verification&, std::size_t index, std::vector<Finding>&);

void check_tile(Verification& v, std::size_t index, std::vector<Finding>& findings) {
  const IndexEntry entry = v.pack.entry(index);
  if (entry.layer == Layer::objects) return check_object_tile(v.pack, entry, findings);
  if (entry.layer == Layer::models) return check_model(v.pack, entry, findings);
  v.digests[index] = check_content(v.pack, entry, findings);
}

void check_relations(Verification& v, std::size_t index, std::vector<Finding>& findings) {
  check_parent(v.pack, index, v.digests, findings);
  check_neighbours(v.pack, index, v.digests, findings);
}

void work(Verification& v, Rule rule, IndexedFindings& found) {
  std::vector<Finding> findings;
  for (;;) {
    const std::size_t index = v.next.fetch_add(1);
    if (index >= v.pack.entry_count() || v.enough()) return;
    rule(v, index, findings);
    v.found += findings.size();
    for (Finding& finding : findings) found.emplace_back(index, std::move(finding));
    findings.clear();
  }
}

/// Applies the rule to every entry, on several threads, and adds what it finds in the index's order.
void check_entries(Verification& v, Rule rule, int threads, std::vector<Finding>& findings) {
  v.next = 0;
  std::vector<IndexedFindings> found(static_cast<std::size_t>(threads));
  std::vector<std::thread> others;
  for (std::size_t t = 1; t < found.size(); ++t) {
    others.emplace_back([&v, rule, &mine = found[t]] { work(v, rule, mine); });
  }
  work(v, rule, found[0]);
  for (std::thread& other : others) other.join();
  IndexedFindings all;
  for (IndexedFindings& part : found) std::move(part.begin(), part.end(), std::back_inserter(all));
  std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  for (auto& [index, finding] : all) findings.push_back(std::move(finding));
}

std::string without_name(const std::filesystem::path& path, const Error& error) {
  const std::string prefix = path.string() + ": ";
  return error.message.starts_with(prefix) ? error.message.substr(prefix.size()) : error.message;
}

/// Whether every page of the index could be read.
Result<bool> check_index(const PackReader& pack, std::vector<Finding>& findings) {
  std::vector<ByteRange> pages;
  const Status read = pack.read_index([&pages](const ByteRange& range) { pages.push_back(range); });
  if (!read && read.error().code != ErrorCode::bad_data) return read.error();
  if (!read) {
    findings.push_back({"index", without_name(pack.path(), read.error())});
    return false;
  }
  check_pages(pack, std::move(pages), findings);
  check_level_table(pack, findings);
  return true;
}

}  // namespace

Result<VerifyReport> verify_pack(const std::filesystem::path& path, const VerifyOptions& options) {
  assert(options.threads >= 1 && options.most_findings >= 1);
  VerifyReport report;
  const Result<PackReader> pack = PackReader::open(path);
  if (!pack && pack.error().code != ErrorCode::bad_data) return pack.error();
  if (!pack) {
    report.findings.push_back({"file", without_name(path, pack.error())});
    return report;
  }
  check_metadata(*pack, report.findings);
  const Result<bool> has_index = check_index(*pack, report.findings);
  if (!has_index) return has_index.error();
  if (!*has_index) return report;
  check_coverage(*pack, report.findings);
  Verification v{*pack, options.most_findings, {}, 0, report.findings.size()};
  v.digests.resize(pack->entry_count());
  check_entries(v, check_tile, options.threads, report.findings);
  check_entries(v, check_relations, options.threads, report.findings);
  if (report.findings.size() < options.most_findings)
    check_rqt_layer(*pack, options.threads, report.findings);
  if (report.findings.size() > options.most_findings) report.findings.resize(options.most_findings);
  return report;
}

}  // namespace cairn
