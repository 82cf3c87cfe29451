#pragma once

#include <cstddef>
#include <iosfwd>
#include <string>
#include <vector>

#include "cairn/geo.h"
#include "cairn/status.h"

namespace cairn {

/// A place, and how its file wrote it.
struct CsvPoint {
  LonLat place;
  std::string lon_text;
  std::string lat_text;
};

/// Places from comma-separated lines. A first line that does not start with a number names the columns, of
/// which `lon` and `lat` are used; without one they are the first two. Empty lines are skipped.
class PointsCsv {
 public:
  /// REQUIRES: the stream outlives this. `name` is the file's, for errors.
  PointsCsv(std::istream& in, std::string name) : in_(in), name_(std::move(name)) {}

  /// The next `most` places or what is left; empty at the end. bad_data names the line.
  Result<std::vector<CsvPoint>> next(std::size_t most);

 private:
  Status take_header(const std::string& line);
  Result<CsvPoint> parse(const std::string& line) const;

  std::istream& in_;
  std::string name_;
  std::size_t line_number_ = 0;
  std::size_t lon_column_ = 0;
  std::size_t lat_column_ = 1;
};

}  // namespace cairn
