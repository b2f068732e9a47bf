// calibrate mag: hard and soft iron of a vehicle, from a recording.
#include <fmt/format.h>

#include <charconv>
#include <chrono>
#include <cmath>

#include "apps/bag/bag_file.hpp"
#include "apps/bag/recorded_topic.hpp"
#include "apps/calibrate/calibration_output.hpp"
#include "apps/calibrate/mag_command.hpp"
#include "apps/command/command.hpp"
#include "apps/command/json.hpp"
#include "apps/robot_file/robot_file.hpp"
#include "control/magnetic_model.hpp"
#include "identify/iron_fit.hpp"
#include "msg/sensors.hpp"
#include "rt/parameters.hpp"

namespace sinew::app {
namespace {

using identify::IronFit;

constexpr std::array<const char*, identify::kIronNumbers> kNames = {
    "hard x", "hard y", "hard z", "soft xx", "soft yy", "soft zz", "soft xy", "soft xz", "soft yz"};
constexpr double kMicro = 1e6;

/// The earth's field where it was recorded, and in words where that comes from.
struct EarthField {
  double strength_t = 0;  // 0: not known
  std::string source;
};

/// When it was recorded; 0: not known, or in virtual time.
std::int64_t unix_ns_of(record::Reader& reader) {
  const record::Texts run = record::read_metadata(reader, "sinew.run");
  std::int64_t ns = 0;
  if (const auto it = run.find("unix_ns"); it != run.end())
    std::from_chars(it->second.data(), it->second.data() + it->second.size(), ns);
  return ns;
}

double year_of(const MagOptions& o, std::int64_t recorded_unix_ns) {
  if (o.year) return *o.year;
  constexpr double kYear_s = 365.2425 * 86400;
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  const double unix_s =
      recorded_unix_ns > 0 ? 1e-9 * static_cast<double>(recorded_unix_ns) : std::chrono::duration<double>(now).count();
  return 1970 + unix_s / kYear_s;
}

/// Not known without --field, --at and one topic with a fix. Nothing, with `why`: a place that has no field.
std::optional<EarthField> earth_field(const MagOptions& o, record::Reader& reader, std::int64_t unix_ns,
                                      std::string& why) {
  if (o.field_ut) return EarthField{*o.field_ut / kMicro, "as told"};
  control::GeodeticPoint at;
  std::string source;
  if (!o.at_deg.empty()) {
    at.latitude_deg = o.at_deg[0], at.longitude_deg = o.at_deg[1];
  } else {
    std::string none;
    const auto topic = topic_of<msg::GnssSample>(reader, {}, none);
    if (!topic) return EarthField{};
    bool fixed = false;
    each_of<msg::GnssSample>(reader, *topic, [&](const msg::GnssSample& s) {
      if (fixed || s.fix < msg::GnssFix::full) return;
      at = {s.latitude_deg, s.longitude_deg, s.altitude_m};
      fixed = true;
    });
    if (!fixed) return EarthField{};
    source = " of " + *topic;
  }
  const double year = year_of(o, unix_ns);
  const auto field = control::earth_field_t(at, year);
  if (!field) {
    why = fmt::format("no field is known at {:.5f} {:.5f} degrees: latitudes from -89.9 to 89.9", at.latitude_deg,
                      at.longitude_deg);
    return std::nullopt;
  }
  return EarthField{norm(*field),
                    fmt::format("World Magnetic Model at {:.4f} {:.4f}{}, {:.1f}{}", at.latitude_deg, at.longitude_deg,
                                source, year, control::magnetic_model_expired(year) ? ", beyond its years" : "")};
}

/// Of each module that reads the topic and knows iron.
std::vector<OverlayParam> params_for(const RobotFile& robot, const rt::ModuleTypes& types, const std::string& topic,
                                     const IronFit& fit) {
  std::vector<OverlayParam> params;
  each_reader(robot, types, topic, [&](const std::string& module, const rt::Declaration& declaration) {
    const auto put = [&](const std::string& name, double value) {
      if (rt::find_param(declaration, name)) params.push_back({module, name, value, 0});
    };
    put("mag_hard_x_t", fit.hard_t.x);
    put("mag_hard_y_t", fit.hard_t.y);
    put("mag_hard_z_t", fit.hard_t.z);
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) put(fmt::format("mag_soft_{}{}", "xyz"[r], "xyz"[c]), fit.soft(r, c));
  });
  return params;
}

/// A direction by the axes of the base that it is along, "+x -z".
std::string axes_of(const math::Vec3& v) {
  std::string text;
  for (const auto& [value, axis] : {std::pair{v.x, 'x'}, {v.y, 'y'}, {v.z, 'z'}})
    if (std::abs(value) > 0.35) text += fmt::format("{}{}{}", text.empty() ? "" : " ", value > 0 ? '+' : '-', axis);
  return text;
}

Json to_json(const IronFit& fit, const std::string& topic, const EarthField& earth) {
  Json json = {{"topic", topic},
               {"readings", fit.readings},
               {"field_t", fit.field_t},
               {"field_from", earth.source.empty() ? Json(nullptr) : Json(earth.source)},
               {"rms_before_t", fit.rms_before_t},
               {"rms_t", fit.rms_t},
               {"held_out_rms_t", std::isfinite(fit.held_out_rms_t) ? Json(fit.held_out_rms_t) : Json(nullptr)},
               {"open_deg", fit.worst_deg},
               {"shown", fit.shown}};
  for (std::size_t i = 0; i < identify::kIronNumbers; ++i)
    json["iron"][kNames[i]] = {{"value", fit.estimates[i].value}, {"half_width_95", fit.estimates[i].half_width}};
  return json;
}

void tell(const IronFit& fit, const std::string& topic, const EarthField& earth) {
  put_text(fmt::format("{}: {} readings; field {:.2f} uT ({})\n", topic, fit.readings, kMicro * fit.field_t,
                       earth.source.empty() ? "not known there: soft iron keeps volumes" : earth.source));
  for (std::size_t i = 0; i < identify::kIronNumbers; ++i) {
    const auto& e = fit.estimates[i];
    const double unit = i < 3 ? kMicro : 1;
    put_text(fmt::format("  {:<9}{:>10.4f} +- {:<8.4f} {}\n", kNames[i], unit * e.value, unit * e.half_width,
                         i < 3 ? "uT" : "1"));
  }
  put_text(
      fmt::format("  strength off by {:.2f} uT RMS before, {:.3f} uT after; in readings that were not fitted by "
                  "{:.3f} uT\n  direction known to {:.2f} degrees or better\n",
                  kMicro * fit.rms_before_t, kMicro * fit.rms_t, kMicro * fit.held_out_rms_t, fit.worst_deg));
}

}  // namespace

int calibrate_mag(const MagOptions& o, const rt::ModuleTypes& types) {
  std::optional<std::string> topic;
  std::optional<EarthField> earth;
  std::vector<math::Vec3> readings;
  RobotFile robot;
  {
    Progress progress("calibrate");
    const auto reader = open_recording(o.recording, progress);
    if (!reader) return kNotBegun;
    std::string why;
    topic = topic_of<msg::MagSample>(*reader, {.named = o.topic}, why);
    if (!topic) return fail(o.recording + ": " + why);
    each_of<msg::MagSample>(*reader, *topic, [&](const msg::MagSample& s) { readings.emplace_back(s.field_t); });
    earth = earth_field(o, *reader, unix_ns_of(*reader), why);
    if (!earth) return fail(why);
    if (const auto text = record::read_attachment(*reader, "robot.toml"))
      robot = parse_robot(*text, "robot.toml").robot;
  }
  const IronFit fit = identify::fit_iron(readings, {.field_t = earth->strength_t});
  if (!fit.problem.empty()) return fail(fmt::format("{}: {}: {}", o.recording, *topic, fit.problem), kFailed);
  const auto params = params_for(robot, types, *topic, fit);
  if (o.json)
    std::printf("%s\n", to_json(fit, *topic, *earth).dump(2, ' ', false, Json::error_handler_t::replace).c_str());
  else
    tell(fit, *topic, *earth);
  if (!fit.shown)
    return fail(fmt::format("not all is shown: a field along {} of the base stays open by {:.1f} degrees; turn the "
                            "vehicle until the field comes from there, too: nothing is written",
                            axes_of(fit.worst), fit.worst_deg),
                kFailed);
  if (params.empty() && !o.json) put_text("  no module of the robot file reads this topic and knows iron\n");
  return write_params({o.file, o.params, o.json}, robot.graph.robot, params);
}

}  // namespace sinew::app
