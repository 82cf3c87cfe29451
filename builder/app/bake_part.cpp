#include "builder/app/bake_part.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "builder/app/watched_work.h"
#include "builder/bake/memory_budget.h"
#include "cairn/shards.h"

namespace cairn {

Status bake_part(const std::string& plan, std::size_t shard, const SessionOptions& session, bool json) {
  const auto report =
      watched([&](const ProgressCallback& progress) { return bake_shard(plan, shard, session, progress); },
              [&](const Error& error) {
                return with_remedies(error, remedies_for_shard(error, session),
                                     std::filesystem::path(session.target).concat(".journal"));
              });
  if (!report) return report.error();
  const double peak_mib = static_cast<double>(peak_resident_bytes()) / 1048576.0;
  if (json) {
    const nlohmann::ordered_json out{{"part", session.target.string()},
                                     {"plan", plan},
                                     {"shard", shard},
                                     {"units", report->units},
                                     {"samples", report->samples},
                                     {"texels", report->texels},
                                     {"file_bytes", report->file_bytes},
                                     {"seconds", report->seconds},
                                     {"threads", report->threads},
                                     {"resumed", report->resumed},
                                     {"peak_rss_mib", peak_mib}};
    fmt::print("{}\n", out.dump(1, ' ', false, nlohmann::json::error_handler_t::replace));
    return {};
  }
  fmt::print("{}: shard {}, {:.2f} MiB, {} samples, {} texels in {:.2f} s ({} threads, peak {:.0f} MiB)\n",
             session.target.string(), shard, static_cast<double>(report->file_bytes) / 1048576.0,
             report->samples, report->texels, report->seconds, report->threads, peak_mib);
  return {};
}

}  // namespace cairn
