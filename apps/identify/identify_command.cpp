// identify: what a recording says about servos, friction and masses.
#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>

#include "apps/bag/bag_file.hpp"
#include "apps/command/json.hpp"
#include "apps/command/number_check.hpp"
#include "apps/identify/commands.hpp"
#include "apps/identify/recorded_joints.hpp"
#include "apps/toml/body_reader.hpp"
#include "math/elementary.hpp"

namespace sinew::app {
namespace {

using identify::ServoEstimate;
using identify::ServoFit;

struct IdentifyCommand {
  std::string file, group, joints, body;
  std::vector<std::string> only;
  double held_out = 0.2, stall_nm = 0;
  std::size_t parts = 8;
  std::vector<double> gravity{0, 0, -9.80665};
  bool json = false;
};

void put(const std::string& text) { std::fwrite(text.data(), 1, text.size(), stdout); }

/// As people say it: milliseconds, degrees.
struct Said {
  double factor = 1;
  std::string unit;
};
Said said(std::string_view unit, std::string_view name) {
  if (name == "delay") return {1e3, "ms"};
  if (name == "play") return {180 / math::kPi, "deg, to each side"};
  return {1, std::string(unit)};
}

Json number_or_null(double x) { return std::isfinite(x) ? Json(x) : Json(nullptr); }

Json to_json(const ServoFit& fit) {
  static constexpr const char* kStates[] = {"identified", "known", "not shown"};
  Json json = Json::object();
  if (!fit.problem.empty()) return {{"problem", fit.problem}};
  for (std::size_t i = 0; i < identify::kServoParameters; ++i) {
    const ServoEstimate& e = fit.estimates[i];
    const auto& text = identify::servo_parameters()[i];
    json["parameters"][std::string(text.name)] = {{"value", number_or_null(e.value)},
                                                  {"half_width_95", number_or_null(e.half_width)},
                                                  {"unit", std::string(text.unit)},
                                                  {"state", kStates[static_cast<std::size_t>(e.state)]}};
  }
  json["encoder"] = fit.model.encoder_at_motor ? "motor" : "joint";
  const auto error = [](const identify::ServoError& e) {
    return Json{{"position_rad", number_or_null(e.position_rad)}, {"effort_nm", number_or_null(e.effort_nm)}};
  };
  json["fitted_rms"] = error(fit.fitted), json["held_out_rms"] = error(fit.held_out),
  json["moved_rms"] = error(fit.moved);
  json["unknown"] = fit.unknown;
  json["encoder_known"] = fit.side_known, json["doubtful"] = fit.doubtful;
  return json;
}

void tell(const std::string& name, const identify::ServoRecord& record, const ServoFit& fit) {
  if (!fit.problem.empty()) return put(fmt::format("{}: {}\n", name, fit.problem));
  put(fmt::format("{}: {:.1f} s alone in motion; encoder at the {}{}\n", name,
                  record.time_s.back() - record.time_s.front(), fit.model.encoder_at_motor ? "motor" : "joint",
                  fit.side_known ? "" : ", or on the other side of the play"));
  for (std::size_t i = 0; i < identify::kServoParameters; ++i) {
    const ServoEstimate& e = fit.estimates[i];
    const auto& text = identify::servo_parameters()[i];
    if (e.state != ServoEstimate::State::identified) continue;
    const Said s = said(text.unit, text.name);
    put(fmt::format("  {:<14}{:>11.5g} +- {:<9.3g}{:<18} {}\n", text.name, s.factor * e.value, s.factor * e.half_width,
                    s.unit, text.doc));
  }
  const auto errors = [](const identify::ServoError& e) {
    return fmt::format("{:.3f} mrad", 1e3 * e.position_rad) +
           (std::isfinite(e.effort_nm) ? fmt::format(", {:.4g} N m", e.effort_nm) : "");
  };
  put(fmt::format("  off by {} RMS; in the part held out by {}, in which it moved by {}\n", errors(fit.fitted),
                  errors(fit.held_out), errors(fit.moved)));
  for (const std::string& unknown : fit.unknown) put("  not shown: " + unknown + "\n");
}

class IdentifyRun {
 public:
  explicit IdentifyRun(const IdentifyCommand& command) : command_(command) {}

  int run() {
    std::unique_ptr<record::Reader> reader;
    Progress progress("identify", true, ProgressOf::cases);
    reader = open_recording(command_.file, progress);
    if (!reader) return kNotBegun;
    std::string why;
    const auto joints = read_joints(*reader, command_.group, command_.joints, why);
    if (!joints) return fail(command_.file + ": " + why);
    for (const std::string& name : command_.only)
      if (std::find(joints->names.begin(), joints->names.end(), name) == joints->names.end())
        return fail(
            fmt::format("{}: there is no joint '{}'; it has: {}", command_.file, name, fmt::join(joints->names, ", ")));
    std::optional<LoadedBody> body;
    if (!command_.body.empty()) {
      body = load_body(command_.body);
      for (const auto& p : body->problems) std::fprintf(stderr, "%s\n", rt::to_string(p, command_.body).c_str());
      if (!body->problems.empty()) return kNotBegun;
    }
    bool any = false;
    for (std::size_t j = 0; j < joints->joints(); ++j) any = fit_joint(*joints, j) || any;
    if (body) any = fit_body(*joints, body->body) || any;
    if (command_.json) std::printf("%s\n", all_.dump(2, ' ', false, Json::error_handler_t::replace).c_str());
    return any ? kDone : fail("no joint's numbers could be found", kFailed);
  }

 private:
  bool fit_joint(const RecordedJoints& joints, std::size_t j) {
    const std::string& name = joints.names[j];
    if (!command_.only.empty() && std::find(command_.only.begin(), command_.only.end(), name) == command_.only.end())
      return false;
    const auto record = joints.alone(j);
    if (!record) {
      const char* const why = "nowhere moves alone for 5 s; control::Excitation moves one joint after the other";
      all_["joints"][name] = {{"problem", why}};
      if (!command_.json) put(name + ": " + why + "\n");
      return false;
    }
    identify::ServoFitOptions options;
    options.held_out_share = command_.held_out;
    options.parts = command_.parts;
    if (command_.stall_nm > 0) options.known.emplace_back(identify::ServoParameter::stall, command_.stall_nm);
    const ServoFit fit = identify::fit_servo(*record, options);
    all_["joints"][name] = to_json(fit);
    if (!command_.json) tell(name, *record, fit);
    return fit.problem.empty();
  }

  bool fit_body(const RecordedJoints& joints, const kinematics::Body& body) {
    std::string why;
    const auto record = joints.together(body, why);
    identify::BaseFit fit;
    if (record) {
      identify::BaseOptions options;
      options.held_out_share = command_.held_out;
      options.gravity_mps2 = {command_.gravity[0], command_.gravity[1], command_.gravity[2]};
      fit = identify::fit_base_parameters(body, *record, options);
      why = fit.problem;
    }
    if (!why.empty()) {
      all_["body"] = {{"problem", why}};
      if (!command_.json) put(body.name + ": " + why + "\n");
      return false;
    }
    tell_body(body, fit);
    return true;
  }

  void tell_body(const kinematics::Body& body, const identify::BaseFit& fit) {
    const std::vector<double> drawn = identify::chain_parameters(body);
    if (!command_.json) put(fmt::format("{}: base parameters\n", body.name));
    Json& json = all_["body"];
    for (std::size_t i = 0; i < fit.set.base.size(); ++i) {
      const identify::BaseColumn& base = fit.set.base[i];
      const identify::BaseEstimate& e = fit.estimates[i];
      double of_file = drawn[base.column];
      for (const auto& part : base.with) of_file += part.factor * drawn[part.column];
      const std::string unit = identify::chain_column_unit(body, base.column);
      json["parameters"].push_back({{"name", identify::base_name(body, base, 99)},
                                    {"value", e.value},
                                    {"half_width_95", number_or_null(e.half_width)},
                                    {"unit", unit},
                                    {"of_file", of_file},
                                    {"identified", e.identified}});
      if (!command_.json)
        put(fmt::format("  {:>11.4g} +- {:<9.3g}{:<10} file: {:<11.4g} {}{}\n", e.value, e.half_width, unit, of_file,
                        identify::base_name(body, base), e.identified ? "" : "  (not shown)"));
    }
    for (std::size_t j = 0; j < body.joints(); ++j) {
      const std::string& name = body.links[j + 1].name;
      json["efforts"][name] = {{"rms_nm", number_or_null(fit.effort_rms_nm[j])},
                               {"fitted_rms_nm", number_or_null(fit.residual_rms_nm[j])},
                               {"held_out_rms_nm", number_or_null(fit.held_out_rms_nm[j])}};
      if (!command_.json)
        put(fmt::format("  {}: effort {:.4g} N m RMS, off by {:.4g}, held out by {:.4g}\n", name, fit.effort_rms_nm[j],
                        fit.residual_rms_nm[j], fit.held_out_rms_nm[j]));
    }
    std::string none;
    for (const std::size_t column : fit.set.without_effect) {
      none += (none.empty() ? "" : ", ") + identify::chain_column_name(body, column);
      json["without_effect"].push_back(identify::chain_column_name(body, column));
    }
    if (!none.empty() && !command_.json) put("  change no effort, so nothing shows them: " + none + "\n");
  }

  const IdentifyCommand& command_;
  Json all_ = Json::object();
};

}  // namespace

void add_identify_command(CLI::App& app, CommandContext& context) {
  const auto o = std::make_shared<IdentifyCommand>();
  CLI::App& command = *app.add_subcommand(
      "identify",
      "friction, delay, play, torque-speed line and masses of joints, from a recording in which they moved");
  command.add_option("file", o->file, "the recording; the module control::Excitation makes good motions")
      ->required()
      ->type_name(kFileHint);
  command.add_option("--group", o->group, "the actuator group, if there are several")->type_name("NAME");
  command.add_option("--joints", o->joints, "the topic of its joints' states, if there are several")
      ->type_name("TOPIC");
  command.add_option("--joint", o->only, "only this joint; may be repeated")
      ->allow_extra_args(false)
      ->type_name("NAME");
  command.add_option("--body", o->body, "its links (docs/bodies.md): base inertial parameters, too")
      ->type_name(kFileHint);
  command.add_option("--gravity", o->gravity, "in the body's first link's frame, m/s^2 [0 0 -9.80665]")
      ->expected(3)
      ->type_name("X Y Z");
  command
      .add_option("--stall", o->stall_nm, "stall torque, N m: where no efforts were recorded, the size of all torques")
      ->check(number(1e-4, 1e5))
      ->type_name("NM");
  command.add_option("--held-out", o->held_out, "share of the record's end that is predicted and not fitted [0.2]")
      ->check(number(0.05, 0.6))
      ->type_name("SHARE");
  command.add_option("--parts", o->parts, "fitted on their own, for the intervals [8]")
      ->check(whole(3, 100))
      ->type_name("N");
  command.add_flag("--json", o->json, "as one JSON object");
  command.callback([&context, o] { context.action = [o] { return IdentifyRun(*o).run(); }; });
}

}  // namespace sinew::app
