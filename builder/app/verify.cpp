#include <algorithm>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include "builder/app/metadata_rules.h"
#include "builder/app/report_error.h"
#include "builder/app/verbs.h"
#include "builder/app/verify_against.h"
#include "format/pack_verify.h"

namespace cairn {
namespace {

using Json = nlohmann::ordered_json;

struct CommandLine {
  std::string pack;
  int threads = 0;  // all
  bool json = false;
  std::vector<std::string> against;
  std::string geoid;
};

/// What the file alone shows: its structure, and, where that opens, its metadata.
Result<VerifyReport> verify_file(const CommandLine& options) {
  VerifyOptions verify;
  verify.threads = options.threads > 0 ? options.threads
                                       : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  Result<VerifyReport> report = verify_pack(options.pack, verify);
  if (!report) return report;
  const Result<PackReader> pack = PackReader::open(options.pack);
  if (!pack) return report;
  for (Finding& finding : check_metadata_json(*pack)) report->findings.push_back(std::move(finding));
  if (options.against.empty() || !report->ok()) return report;
  auto found = verify_against(*pack, options.against, options.geoid, verify.threads);
  if (!found) return found.error();
  for (Finding& finding : *found) report->findings.push_back(std::move(finding));
  return report;
}

void print_report(const CommandLine& options, const VerifyReport& report) {
  if (!options.json) {
    for (const Finding& finding : report.findings) fmt::print("{}: {}\n", finding.where, finding.what);
    fmt::print("{}: {}\n", options.pack,
               report.ok() ? "ok" : fmt::format("{} findings", report.findings.size()));
    return;
  }
  Json findings = Json::array();
  for (const Finding& finding : report.findings) {
    findings.push_back({{"where", finding.where}, {"what", finding.what}});
  }
  const Json document = {{"ok", report.ok()}, {"findings", findings}};
  fmt::print("{}\n", document.dump(2, ' ', false, Json::error_handler_t::replace));
}

int run_verify(const CommandLine& options) {
  const Result<VerifyReport> report = verify_file(options);
  if (!report) return report_error(report.error());
  print_report(options, *report);
  return report->ok() ? 0 : static_cast<int>(ErrorCode::bad_data);
}

}  // namespace

void add_verify(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<CommandLine>();
  CLI::App* verb = app.add_subcommand("verify", "Check every byte and every rule of a pack");
  verb->add_option("PACK", options->pack, "The pack")->required();
  verb->add_option("--threads", options->threads, "Threads to use (0: all)")->check(CLI::Range(0, 1024));
  verb->add_option("--against", options->against, "The DEMs it was baked from: measure every post anew");
  verb->add_option("--geoid", options->geoid, "The geoid that it was baked with")->check(CLI::ExistingFile);
  verb->add_flag("--json", options->json, "Print JSON");
  verb->callback([options, &exit_code] { exit_code = run_verify(*options); });
}

}  // namespace cairn
