#include "builder/raster/expand_inputs.h"

#include <catch2/catch.hpp>

#include "tests/support/dem_files.h"
#include "tests/support/test_data.h"

namespace cairn::test {
namespace {

std::vector<std::string> names_of(const std::vector<std::string>& arguments) {
  const auto files = expand_inputs(arguments);
  if (!files) return {"error: " + files.error().message};
  std::vector<std::string> names;
  for (const auto& file : files->files) names.push_back(file.filename().string());
  return names;
}

}  // namespace

TEST_CASE("Inputs are files, folders and patterns, in the order given and sorted within each") {
  const TempDir folder;
  const std::string at = folder.path().string();
  for (const char* name :
       {"b.tif", "a.HGT", "c.dt1", "c.dt1.aux.xml", "notes.txt", "a.tfw", ".hidden.tif", "x[1].tif"})
    write_text(folder.path() / name, "x");
  std::filesystem::create_directory(folder.path() / "deeper.tif");
  using Names = std::vector<std::string>;
  CHECK(names_of({at}) == Names{"a.HGT", "b.tif", "c.dt1", "x[1].tif"});
  CHECK(names_of({at + "/notes.txt", at + "/a.HGT"}) == Names{"notes.txt", "a.HGT"});
  CHECK(names_of({at + "/*.tif", at + "/?.dt1"}) == Names{"b.tif", "x[1].tif", "c.dt1"});
  CHECK(names_of({at + "/x[1].tif"}) == Names{"x[1].tif"});
  for (const std::string& bad :
       {at + "/none.tif", at + "/*.xyz", at + "/deeper.tif", at + "/no/such/*.tif", std::string()}) {
    const Names names = names_of({at + "/b.tif", bad});
    REQUIRE(names.size() == 1);
    CHECK(names[0].find("expected") != std::string::npos);
  }
}

TEST_CASE("A file that is no raster, is empty or is not there gives one line that says so") {
  const TempDir folder;
  const auto path = folder.path() / "x.bin";
  CHECK(complaint_of(path).find("No such file") != std::string::npos);
  CHECK(complaint_of(folder.path()).find("regular file") != std::string::npos);
  write_text(path, "");
  CHECK(complaint_of(path).find("expected a raster") != std::string::npos);
  write_text(path, "this is no raster, whatever its name");
  CHECK(complaint_of(path).find("expected") != std::string::npos);
  CHECK(complaint_of(path).find('\n') == std::string::npos);
}

}  // namespace cairn::test
