#include "cairn/update.h"

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "builder/app/bake_options.h"
#include "builder/app/bake_report.h"
#include "builder/app/report_error.h"
#include "builder/app/verbs.h"
#include "builder/app/watched_work.h"

namespace cairn {
namespace {

using Json = nlohmann::ordered_json;

struct UpdateArguments {
  UpdateOptions options;
  std::vector<std::string> inputs;
  std::vector<std::string> images;
  std::vector<std::string> places;
  std::vector<std::string> removed;
  InputSearch search;
  std::size_t memory_mib = 1024;
  bool json = false;
};

void print_plan(const UpdateReport& report, bool json) {
  if (json) {
    Json out{
        {"units_made", report.made_units}, {"units_taken", report.taken_units}, {"changes", Json::array()}};
    for (const auto& change : report.changes)
      out["changes"].push_back({{"what", change.what}, {"file", change.path.string()}});
    fmt::print("{}\n", out.dump(1, ' ', false, Json::error_handler_t::replace));
    return;
  }
  for (const auto& change : report.changes) fmt::print("{:>8}: {}\n", change.what, change.path.string());
  fmt::print("{} of {} subtrees of tiles are made again, the others are taken from the pack\n",
             report.made_units, report.made_units + report.taken_units);
}

Status update(UpdateArguments arguments) {
  UpdateOptions& options = arguments.options;
  const auto find = [&](const std::vector<std::string>& names, std::vector<std::filesystem::path>& files) {
    return names.empty() ? Status() : find_inputs(names, arguments.search, files);
  };
  if (auto status = find(arguments.inputs, options.dems); !status) return status;
  if (auto status = find(arguments.images, options.images); !status) return status;
  options.removed.assign(arguments.removed.begin(), arguments.removed.end());
  options.places.assign(arguments.places.begin(), arguments.places.end());
  if (options.dems.empty() && options.images.empty() && options.removed.empty() && options.places.empty() &&
      options.models.empty())
    return usage_error(
        "update: expected inputs, --imagery, --objects, --models or --remove, found none of them");
  if (options.session.target.empty()) options.session.target = options.pack;
  options.session.memory_bytes = arguments.memory_mib << 20;
  BuildOptions of_session;
  of_session.session = options.session;
  const auto report =
      watched([&](const ProgressCallback& progress) { return update_pack(options, progress); },
              [&](const Error& error) {
                return with_remedies(error, remedies_for(error, of_session),
                                     std::filesystem::path(options.session.target).concat(".part"));
              });
  if (!report) return report.error();
  if (!report->knows_units)
    fmt::print(stderr,
               "cairn: warning: {0}: no {0}.units of this pack is beside it, so every tile is made again\n",
               options.pack.string());
  if (options.dry_run) {
    print_plan(*report, arguments.json);
    return {};
  }
  if (!arguments.json) print_plan(*report, false);
  if (!report->build.warning.empty()) fmt::print(stderr, "cairn: warning: {}\n", report->build.warning);
  return print_bake_report(report->build, report->options, "", arguments.json);
}

}  // namespace

void add_update(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<UpdateArguments>();
  UpdateOptions& o = arguments->options;
  CLI::App* verb = app.add_subcommand("update", "Change the inputs of a pack, baking only what that changes");
  verb->add_option("pack", o.pack, "the pack")->required()->check(CLI::ExistingFile);
  verb->add_option(
      "dem", arguments->inputs,
      "DEMs that are new, or new versions of the pack's own of the same name; as cairn bake takes "
      "them");
  verb->add_option("--imagery", arguments->images, "images, likewise");
  verb->add_option("--objects", arguments->places, "places of objects, likewise")->check(CLI::ExistingFile);
  verb->add_option("--models", o.models, "the folder of the objects' models, where it is another one")
      ->check(CLI::ExistingDirectory);
  verb->add_option("--remove", arguments->removed, "a source of the pack to leave out, by its file's name")
      ->allow_extra_args(false);
  verb->add_flag("--recursive", arguments->search.recursive, "search folders with all folders in them");
  verb->add_option("-o,--output", o.session.target, "the pack to make; by default the pack is replaced");
  verb->add_option("--memory", arguments->memory_mib, "MiB that the program stays under")
      ->check(CLI::Range(64, 1 << 24))
      ->capture_default_str();
  verb->add_option("--threads", o.session.threads, "0 for all")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  verb->add_flag("--resume", o.session.resume, "go on with an interrupted update to the same target");
  verb->add_flag("--force", o.session.force, "replace the output");
  verb->add_flag("--dry-run", o.dry_run, "say what would be done");
  verb->add_flag("--json", arguments->json, "print the report as JSON");
  verb->callback([arguments, &exit_code] {
    const Status status = update(*arguments);
    exit_code = status.ok() ? 0 : report_error(status.error());
  });
}

}  // namespace cairn
