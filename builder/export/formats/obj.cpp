// A region as a folder with a Wavefront OBJ, its material and its image.
#include <string>
#include <vector>

#include <fmt/format.h>

#include "builder/export/export_folder.h"
#include "builder/export/mesh_export.h"
#include "builder/export/region_mesh.h"

namespace cairn {
namespace {

constexpr const char *kMesh = "terrain.obj", *kMaterial = "terrain.mtl", *kImage = "terrain.jpg";

std::string obj_of(const RegionMesh& region) {
  const GlbMesh& mesh = region.ground;
  const bool has_image = !mesh.jpeg.empty();
  std::string out = fmt::format("# cairn {} {}\nmtllib {}\nusemtl terrain\n", CAIRN_VERSION,
                                describe_region_mesh(region), kMaterial);
  // y is up, and a texture's second coordinate counts from the image's south.
  for (const Vector3& p : mesh.positions)
    fmt::format_to(std::back_inserter(out), "v {:.3f} {:.3f} {:.3f}\n", p[0], p[2], -p[1]);
  if (has_image)
    for (const auto& t : mesh.texture)
      fmt::format_to(std::back_inserter(out), "vt {:.6f} {:.6f}\n", t[0], 1 - t[1]);
  for (const Vector3& n : mesh.normals)
    fmt::format_to(std::back_inserter(out), "vn {:.4f} {:.4f} {:.4f}\n", n[0], n[2], -n[1]);
  for (const auto& triangle : mesh.triangles) {
    out += 'f';
    for (const std::uint32_t i : triangle) {
      if (has_image) {
        fmt::format_to(std::back_inserter(out), " {0}/{0}/{0}", i + 1);
      } else {
        fmt::format_to(std::back_inserter(out), " {0}//{0}", i + 1);
      }
    }
    out += '\n';
  }
  return out;
}

Status write_files(const ExportFolder& folder, const RegionMesh& mesh, const std::string& obj) {
  const std::vector<std::byte>& jpeg = mesh.ground.jpeg;
  if (auto status = folder.write(kMesh, obj); !status) return status;
  const std::string image = jpeg.empty() ? "" : fmt::format("map_Kd {}\n", kImage);
  if (auto status = folder.write(kMaterial, "newmtl terrain\nKd 1 1 1\nKs 0 0 0\nillum 1\n" + image); !status)
    return status;
  return jpeg.empty() ? Status() : folder.write(kImage, jpeg);
}

Result<ExportReport> write(const PackReader& pack, const ExportOptions& options,
                           const ProgressCallback& progress) {
  auto folder = ExportFolder::begin(options.target,
                                    mesh_export_identity("obj", pack, options, pack.header().vertical_datum),
                                    options.resume);
  if (!folder) return folder.error();
  const auto mesh = make_region_mesh(pack, options, progress);
  if (!mesh) {
    folder->discard();
    return mesh.error();
  }
  const std::string obj = obj_of(*mesh);
  if (auto status = write_files(*folder, *mesh, obj); !status) return status.error();
  if (auto status = folder->finish(); !status) return status.error();
  return report_of(*mesh, obj.size() + mesh->ground.jpeg.size());
}

}  // namespace

extern const ExportFormat obj_exporter;
const ExportFormat obj_exporter{"obj", "likewise as a folder with terrain.obj, its material and its image",
                                write};

}  // namespace cairn
