// A region as one binary glTF 2.0 file.
#include <nlohmann/json.hpp>

#include "builder/export/export_folder.h"
#include "builder/export/mesh_export.h"
#include "builder/export/region_mesh.h"

namespace cairn {
namespace {

constexpr const char* kName = "mesh.glb";

Result<ExportReport> write(const PackReader& pack, const ExportOptions& options,
                           const ProgressCallback& progress) {
  auto folder = ExportFolder::begin(options.target,
                                    mesh_export_identity("glb", pack, options, pack.header().vertical_datum),
                                    options.resume);
  if (!folder) return folder.error();
  auto mesh = make_region_mesh(pack, options, progress);
  if (!mesh) {
    folder->discard();
    return mesh.error();
  }
  mesh->ground.about = describe_region_mesh(*mesh);
  const std::vector<std::byte> bytes = encode_glb(mesh->ground);
  if (auto status = folder->write(kName, bytes); !status) return status.error();
  if (auto status = folder->finish_as_file(kName); !status) return status.error();
  return report_of(*mesh, bytes.size());
}

}  // namespace

extern const ExportFormat glb_exporter;
const ExportFormat glb_exporter{
    "glb", "a region as one glTF mesh on a plane, the imagery on it, for Blender and engines", write};

}  // namespace cairn
