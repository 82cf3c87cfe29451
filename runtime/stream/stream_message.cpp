#include "runtime/stream/stream_message.h"

#include <cmath>

#include <nlohmann/json.hpp>

namespace cairn::stream {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kLeastSide = 64;
constexpr viewer::Size kMostSize{1920, 1080};

// Reads the fields of a message; the first that is wrong is the error.
class FieldReader {
 public:
  explicit FieldReader(const Json& json) : json_(json) {}

  const Json* find(const char* name) const {
    const auto at = json_.find(name);
    return at == json_.end() ? nullptr : &*at;
  }

  std::optional<double> number(const char* name, double least, double most) {
    const Json* field = find(name);
    if (field == nullptr) return std::nullopt;
    return number_of(*field, name, least, most);
  }

  std::optional<double> number_of(const Json& field, const std::string& name, double least, double most) {
    const double value = field.is_number() ? field.get<double>() : std::nan("");
    if (value >= least && value <= most) return value;
    expect(name, "a number from " + Json(least).dump() + " to " + Json(most).dump(), field);
    return std::nullopt;
  }

  std::optional<std::uint64_t> count(const char* name) {
    const Json* field = find(name);
    if (field == nullptr) return std::nullopt;
    if (field->is_number_unsigned()) return field->get<std::uint64_t>();
    expect(name, "a whole number", *field);
    return std::nullopt;
  }

  /// Returns the field where it is an array of so many values.
  const Json* array(const char* name, std::size_t values) {
    const Json* field = find(name);
    if (field == nullptr) return nullptr;
    if (field->is_array() && field->size() == values) return field;
    expect(name, "an array of " + std::to_string(values) + " numbers", *field);
    return nullptr;
  }

  void expect(const std::string& name, const std::string& expected, const Json& found) {
    if (!status_.ok()) return;
    const std::string text = found.dump(-1, ' ', false, Json::error_handler_t::replace).substr(0, 80);
    status_ = bad_data("viewer: " + name + ": expected " + expected + ", found " + text);
  }

  const Status& status() const { return status_; }

 private:
  const Json& json_;
  Status status_;
};

std::optional<viewer::Size> read_size(FieldReader& reader) {
  const Json* sides = reader.array("size", 2);
  if (sides == nullptr) return std::nullopt;
  const auto width = reader.number_of((*sides)[0], "size", kLeastSide, kMostSize.width);
  const auto height = reader.number_of((*sides)[1], "size", kLeastSide, kMostSize.height);
  if (!width || !height) return std::nullopt;
  return viewer::Size{static_cast<int>(*width), static_cast<int>(*height)};
}

std::optional<ViewState> read_camera(FieldReader& reader) {
  const Json* values = reader.array("camera", 5);
  if (values == nullptr) return std::nullopt;
  const auto lon = reader.number_of((*values)[0], "camera: longitude", -360, 360);
  const auto lat = reader.number_of((*values)[1], "camera: latitude", -90, 90);
  const auto height = reader.number_of((*values)[2], "camera: height", -20000, 1e8);
  const auto heading = reader.number_of((*values)[3], "camera: heading", -360, 360);
  const auto pitch = reader.number_of((*values)[4], "camera: pitch", -90, 90);
  if (!lon || !lat || !height || !heading || !pitch) return std::nullopt;
  ViewState view;
  view.eye = {std::remainder(*lon, 360.0), *lat};
  view.height_m = *height;
  view.heading_deg = *heading;
  view.pitch_deg = *pitch;
  return view;
}

std::optional<HeldKeys> read_held(FieldReader& reader) {
  const Json* values = reader.array("held", 4);
  if (values == nullptr) return std::nullopt;
  const auto ahead = reader.number_of((*values)[0], "held: ahead", -1, 1);
  const auto aside = reader.number_of((*values)[1], "held: aside", -1, 1);
  const auto climb = reader.number_of((*values)[2], "held: climb", -1, 1);
  const auto speed = reader.number_of((*values)[3], "held: speed", 0.01, 10);
  if (!ahead || !aside || !climb || !speed) return std::nullopt;
  return HeldKeys{*ahead, *aside, *climb, *speed};
}

double rounded(double value, double steps) {
  return std::round(value * steps) / steps;
}

}  // namespace

Result<ViewerMessage> parse_viewer_message(std::string_view text) {
  const Json json = Json::parse(text, nullptr, false);
  if (!json.is_object()) return bad_data("viewer: expected a JSON object, found other bytes");
  ViewerMessage message;
  FieldReader reader(json);
  message.size = read_size(reader);
  message.camera = read_camera(reader);
  message.held = read_held(reader);
  message.home = reader.find("home") != nullptr;
  message.hour = reader.number("hour", 0, 24);
  message.turn_deg = reader.number("turn", -360, 360).value_or(0);
  message.tilt_deg = reader.number("tilt", -360, 360).value_or(0);
  message.zoom_steps = reader.number("zoom", -100, 100).value_or(0);
  message.input = reader.count("input");
  message.shown = reader.count("shown");
  if (!reader.status().ok()) return reader.status().error();
  return message;
}

std::string frame_message(const FrameNote& note, std::string_view jpeg) {
  const ViewState& view = note.view;
  const Json json{{"frame", note.frame},
                  {"input", note.input},
                  {"size", {view.viewport_width_px, view.viewport_height_px}},
                  {"camera",
                   {rounded(view.eye.lon, 1e8), rounded(view.eye.lat, 1e8), rounded(view.height_m, 1e3),
                    rounded(view.heading_deg, 1e4), rounded(view.pitch_deg, 1e4)}},
                  {"draw_ms", rounded(note.draw_ms, 10)},
                  {"encode_ms", rounded(note.encode_ms, 10)},
                  {"complete", note.is_complete},
                  {"error_px", rounded(note.error_px, 100)}};
  const std::string text = json.dump();
  std::string message;
  message.reserve(4 + text.size() + jpeg.size());
  for (int shift = 0; shift < 32; shift += 8)
    message.push_back(static_cast<char>(text.size() >> shift & 0xFF));
  message += text;
  message += jpeg;
  return message;
}

}  // namespace cairn::stream
