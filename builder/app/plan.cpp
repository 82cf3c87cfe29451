#include <cstdint>
#include <memory>
#include <optional>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "builder/app/bake_options.h"
#include "builder/app/report_error.h"
#include "builder/app/verbs.h"
#include "builder/app/watched_work.h"
#include "builder/bake/memory_budget.h"
#include "cairn/shards.h"

namespace cairn {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kMiB = 1048576.0;

struct PlanArguments {
  BakeArguments bake;
  std::optional<std::uint64_t> shards;
  std::optional<std::uint64_t> shard_mib;
  bool json = false;
};

Json json_of(const PlanReport& report, const std::string& file) {
  Json out{{"plan", file},
           {"files", report.files},
           {"memory_bytes", report.memory_bytes},
           {"peak_rss_mib", static_cast<double>(peak_resident_bytes()) / kMiB}};
  out["shards"] = Json::array();
  for (const PlanReport::Shard& shard : report.shards) {
    out["shards"].push_back({{"shard", out["shards"].size()},
                             {"height_leaves", shard.height_leaves},
                             {"texture_leaves", shard.texture_leaves},
                             {"files", shard.files},
                             {"file_bytes", shard.file_bytes},
                             {"estimated_bytes", shard.estimated_bytes},
                             {"estimated_seconds", shard.estimated_seconds}});
  }
  return out;
}

void print_table(const PlanReport& report, const std::string& file) {
  for (std::size_t s = 0; s < report.shards.size(); ++s) {
    const PlanReport::Shard& shard = report.shards[s];
    fmt::print(
        "shard {:>4}: {:>6} height tiles, {:>6} textures, reads {:>5} files of {:>9.1f} MiB, about "
        "{:>8.1f} MiB, {:.3g} s\n",
        s, shard.height_leaves, shard.texture_leaves, shard.files,
        static_cast<double>(shard.file_bytes) / kMiB, static_cast<double>(shard.estimated_bytes) / kMiB,
        shard.estimated_seconds);
  }
  fmt::print("{}: {} shards of {} files, each under {:.0f} MiB of memory\n", file, report.shards.size(),
             report.files, static_cast<double>(report.memory_bytes) / kMiB);
}

Status plan(const PlanArguments& arguments) {
  if (arguments.shards.has_value() == arguments.shard_mib.has_value())
    return usage_error("plan: expected one of --shards and --shard-size, found " +
                       std::string(arguments.shards ? "both" : "neither"));
  const auto options = options_from(arguments.bake);
  if (!options) return options.error();
  ShardSize size{arguments.shards, std::nullopt};
  if (arguments.shard_mib) size.bytes = *arguments.shard_mib << 20;
  const auto report =
      watched([&](const ProgressCallback& progress) { return plan_shards(*options, size, progress); },
              [&](const Error& error) { return with_remedies(error, remedies_for(error, *options), ""); },
              ProgressUnit::parts);
  if (!report) return report.error();
  const std::string file = options->session.target.string();
  if (arguments.json) {
    fmt::print("{}\n", json_of(*report, file).dump(1, ' ', false, Json::error_handler_t::replace));
  } else {
    print_table(*report, file);
  }
  return {};
}

}  // namespace

void add_plan(CLI::App& app, int& exit_code) {
  auto arguments = std::make_shared<PlanArguments>();
  CLI::App* verb = app.add_subcommand("plan", "Divide a bake into shards for several machines");
  verb->add_option("-o,--output", arguments->bake.options.session.target, "the plan to write, JSON")
      ->required();
  verb->add_option("--shards", arguments->shards, "into how many shards")->check(CLI::Range(1, 100'000));
  verb->add_option("--shard-size", arguments->shard_mib, "MiB that a shard's part has, about")
      ->check(CLI::Range(1, 1 << 30));
  add_bake_options(*verb, arguments->bake);
  add_machine_options(*verb, arguments->bake);
  verb->add_flag("--force", arguments->bake.options.session.force, "replace the plan");
  verb->add_flag("--json", arguments->json, "print the shards as JSON");
  verb->callback([arguments, &exit_code] {
    const Status status = plan(*arguments);
    exit_code = status.ok() ? 0 : report_error(status.error());
  });
}

}  // namespace cairn
