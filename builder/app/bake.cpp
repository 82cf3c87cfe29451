#include <algorithm>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "builder/app/bake_options.h"
#include "builder/app/bake_part.h"
#include "builder/app/bake_report.h"
#include "builder/app/report_error.h"
#include "builder/app/verbs.h"
#include "builder/app/watched_work.h"
#include "builder/bake/output_check.h"
#include "builder/raster/gdal_name.h"
#include "cairn/bake_estimate.h"
#include "cairn/build.h"

namespace cairn {
namespace {

/// The report is written last, and must then neither be refused nor take the place of something else.
Status check_report(const std::string& report, const BuildOptions& options) {
  if (report.empty()) return {};
  std::vector<std::filesystem::path> others = options.mosaic.inputs;
  others.insert(others.end(), options.imagery.inputs.begin(), options.imagery.inputs.end());
  for (auto& other : others) other = file_of_gdal_name(other).value_or(other);
  if (options.mosaic.geoid) others.push_back(*options.mosaic.geoid);
  for (const char* suffix : {"", ".part", ".journal"}) {
    others.push_back(std::filesystem::path(options.session.target).concat(suffix));
    if (std::filesystem::path(report).lexically_normal() == others.back().lexically_normal())
      return usage_error(report + ": report: expected a name of its own, found the target's");
  }
  if (auto status = check_is_no_input(report, others); !status) return status;
  if (auto status = check_can_be_file(report); !status) return status;
  std::error_code ignored;
  if (std::filesystem::file_size(report, ignored) == 0) return {};
  std::ifstream there(report);
  char first = 0;
  if (!there || !(there >> first) || first == '{') return {};
  return usage_error(report + ": report: expected no such file or a report to replace, found another file");
}

struct BakeVerb {
  BakeArguments bake;
  std::string report;
  std::string plan;
  std::optional<std::size_t> shard;
  bool dry_run = false;
  bool json = false;
};

/// A plan states all that decides the bytes: of the rest of the options these few are left.
Status check_options_beside_plan(const CLI::App& verb) {
  const std::vector<std::string> allowed{"--plan",    "--shard",  "--output", "--memory",
                                         "--threads", "--resume", "--force",  "--json"};
  for (const CLI::Option* option : verb.get_options()) {
    const std::string name = option->get_name();
    if (option->count() == 0 || std::find(allowed.begin(), allowed.end(), name) != allowed.end()) continue;
    return usage_error("--plan: expected no " + name + ", which the plan decides, found one");
  }
  return {};
}

Status bake_of_plan(const BakeVerb& verb, const CLI::App& parsed) {
  if (auto status = check_options_beside_plan(parsed); !status) return status;
  if (!verb.shard) return usage_error("--plan: expected --shard with it, found none");
  SessionOptions session = verb.bake.options.session;
  session.memory_bytes = parsed.count("--memory") > 0 ? verb.bake.memory_mib << 20 : 0;
  return bake_part(verb.plan, *verb.shard, session, verb.json);
}

Status bake(const BakeVerb& verb) {
  if (verb.shard) return usage_error("--shard: expected --plan with it, found none");
  const auto options = options_from(verb.bake);
  if (!options) return options.error();
  if (auto status = check_report(verb.report, *options); !status) return status;
  if (verb.dry_run) {
    const auto dry = dry_run(*options);
    if (!dry) return dry.error();
    print_dry_run(*dry, verb.json);
    return {};
  }
  const auto report =
      watched([&](const ProgressCallback& progress) { return build(*options, progress); },
              [&](const Error& error) {
                return with_remedies(error, remedies_for(error, *options),
                                     std::filesystem::path(options->session.target).concat(".part"));
              });
  if (!report) return report.error();
  if (!report->warning.empty()) fmt::print(stderr, "cairn: warning: {}\n", report->warning);
  return print_bake_report(*report, *options, verb.report, verb.json);
}

void add_work_options(CLI::App& verb, BakeVerb& arguments) {
  SessionOptions& o = arguments.bake.options.session;
  add_machine_options(verb, arguments.bake);
  verb.add_flag("--resume", o.resume, "go on with an interrupted bake to the same target");
  verb.add_flag("--force", o.force, "replace the target");
  verb.add_flag("--dry-run", arguments.dry_run, "say what would be done");
  verb.add_option("--report", arguments.report, "write the report as JSON to this file");
  verb.add_flag("--json", arguments.json, "print the report as JSON");
  verb.add_option("--plan", arguments.plan, "bake one shard of this plan of cairn plan into a part");
  verb.add_option("--shard", arguments.shard, "which shard of the plan, from 0");
}

}  // namespace

void add_bake(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<BakeVerb>();
  CLI::App* verb = app.add_subcommand("bake", "Make a pack from DEMs and images");
  verb->add_option("-o,--output", arguments->bake.options.session.target, "the pack to make")->required();
  add_bake_options(*verb, arguments->bake);
  add_work_options(*verb, *arguments);
  verb->callback([arguments, verb, &exit_code] {
    const Status status = arguments->plan.empty() ? bake(*arguments) : bake_of_plan(*arguments, *verb);
    exit_code = status.ok() ? 0 : report_error(status.error());
  });
}

}  // namespace cairn
