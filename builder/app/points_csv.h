#pragma once

#include <cstddef>
#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

#include "cairn/geo.h"
#include "cairn/status.h"

namespace cairn {

/// A line of a table of places, as its file wrote it.
struct CsvPoint {
  std::optional<LonLat> place;  ///< none where the line has no two numbers in its place's columns
  std::string lon_text;
  std::string lat_text;
  std::vector<std::string> others;  ///< the line's other columns, in their order
};

/// Places from lines of text: separated by tabs, semicolons, commas or blanks, whichever of these (in this
/// order) the first line has. Fields may be quoted. With tabs and semicolons numbers may have decimal commas.
/// A first line that names columns, or has no number in it, is a header: those of the place are `lon`,
/// `longitude`, `long`, `lng` or `x`, and `lat`, `latitude` or `y`, in any case, or what the caller says.
/// Without such a line the first two columns are the place, longitude first. A UTF-8 byte order mark and
/// empty lines are skipped.
class PointsCsv {
 public:
  /// REQUIRES: the stream outlives this. `name` is the file's, for errors. `columns` are the names of the
  /// place's columns, longitude first, or empty.
  PointsCsv(std::istream& in, std::string name, std::vector<std::string> columns = {})
      : in_(in), name_(std::move(name)), columns_(std::move(columns)) {}

  /// The next `most` lines or what is left; empty at the end. bad_data where the first line names columns,
  /// but not those of a place, or is no text in UTF-8.
  Result<std::vector<CsvPoint>> next(std::size_t most);

  /// The separator; known after the first next().
  char separator() const { return separator_; }
  /// Names of the columns beside the place's; `column3` and so on where no line names them.
  const std::vector<std::string>& other_names() const { return other_names_; }
  bool has_decimal_commas() const { return decimal_commas_; }

  /// One line for each line without a place: "FILE: line N: expected …", the first ten and a count of the
  /// rest.
  std::vector<std::string> complaints() const;

 private:
  Status begin(const std::string& line, bool& is_header);
  Status take_header(const std::vector<std::string>& names);
  CsvPoint parse(const std::string& line);
  void complain(const std::string& line);

  std::istream& in_;
  std::string name_;
  std::vector<std::string> columns_;
  std::vector<std::string> other_names_;
  std::vector<std::string> complaints_;
  std::size_t bad_lines_ = 0;
  std::size_t line_number_ = 0;
  std::size_t lon_column_ = 0;
  std::size_t lat_column_ = 1;
  bool begun_ = false;
  bool decimal_commas_ = false;
  char separator_ = ',';
};

/// The field as a file with this separator writes it: quoted where it has to be.
std::string csv_field(const std::string& text, char separator);

}  // namespace cairn
