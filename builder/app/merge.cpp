#include <filesystem>
#include <memory>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "builder/app/bake_report.h"
#include "builder/app/report_error.h"
#include "builder/app/verbs.h"
#include "builder/app/watched_work.h"
#include "cairn/shards.h"

namespace cairn {
namespace {

struct MergeArguments {
  std::filesystem::path plan;
  std::vector<std::filesystem::path> parts;
  BuildOptions options;
  bool json = false;
};

// A merge that was interrupted begins anew: its work is no bake's to go on from.
std::vector<Remedy> remedies_for_merge(const Error& error, const BuildOptions& options) {
  std::vector<Remedy> remedies = remedies_for(error, options);
  std::erase(remedies, Remedy::resume);
  std::erase(remedies, Remedy::accept_error);
  return remedies;
}

Status merge(const MergeArguments& arguments) {
  const BuildOptions& options = arguments.options;
  const auto report = watched(
      [&](const ProgressCallback& progress) {
        return merge_parts(arguments.plan, arguments.parts, options.session, progress);
      },
      [&](const Error& error) { return with_remedies(error, remedies_for_merge(error, options), ""); });
  if (!report) return report.error();
  if (!report->warning.empty()) fmt::print(stderr, "cairn: warning: {}\n", report->warning);
  return print_bake_report(*report, options, "", arguments.json);
}

}  // namespace

void add_merge(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<MergeArguments>();
  SessionOptions& o = arguments->options.session;
  CLI::App* verb = app.add_subcommand("merge", "Put the parts of a plan's shards together to a pack");
  verb->add_option("plan", arguments->plan, "the plan that cairn plan wrote")->required();
  verb->add_option("part", arguments->parts, "a part for each of its shards, in any order")->required();
  verb->add_option("-o,--output", o.target, "the pack to make")->required();
  verb->add_option("--threads", o.threads, "0 for all")->check(CLI::Range(0, 1024))->capture_default_str();
  verb->add_flag("--force", o.force, "replace the target");
  verb->add_flag("--json", arguments->json, "print the report as JSON");
  verb->callback([arguments, &exit_code] {
    const Status status = merge(*arguments);
    exit_code = status.ok() ? 0 : report_error(status.error());
  });
}

}  // namespace cairn
