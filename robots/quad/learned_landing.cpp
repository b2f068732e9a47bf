#include "robots/quad/learned_landing.hpp"

#include "control/plausible.hpp"

namespace sinew::control {

using namespace std::chrono_literals;

void LearnedLanding::declare(rt::Declaration& d) {
  d.in("sighting", sighting_);
  d.in("state", state_, {.max_age = 50ms});
  d.out("guide", guide_);
  d.state(pilot_);
  d.param("actions", actions_, {.doc = "\"discrete\" or \"continuous\": what the weights are for; at the start"});
  d.param("aside", aside_, {.doc = "weights of the learner for the way aside, numbers; at the start"});
  d.param("down", down_, {.doc = "weights of the learner for the way down, numbers; at the start"});
  LandingViewParams& v = pilot_.view.params;
  d.param("min_confidence", v.min_confidence,
          {.unit = "1", .min = 0.01, .max = 1, .doc = "sightings below are not used"});
  d.param("blind_below_m", v.blind_below_m,
          {.unit = "m", .min = 0.1, .max = 5, .doc = "camera above the pad: lower, pictures are not used any more"});
  d.param("lost_s", v.lost_s, {.unit = "s", .min = 0.05, .max = 10, .doc = "unseen for so long: it hovers"});
  d.param("gain", v.gain, {.unit = "1", .min = 0.05, .max = 1, .doc = "of a sighting on offset and height"});
  d.param("blind_sink_mps", pilot_.params.blind_sink_mps,
          {.unit = "m/s", .min = 0.05, .max = 2, .doc = "sinking below blind_below_m"});
  d.param("decide_every", pilot_.params.decide_every,
          {.unit = "1", .min = 1, .max = 30, .doc = "pictures from decision to decision"});
}

hal::Status LearnedLanding::configure(rt::Setup& setup) {
  if (actions_ != "discrete" && actions_ != "continuous") {
    setup.explain("actions: \"" + actions_ + "\": \"discrete\" or \"continuous\"");
    return hal::Error{hal::Errc::bad_argument, "a learned landing's actions"};
  }
  policy_ =
      std::make_unique<LandingPolicy>(actions_ == "discrete" ? LandingActions::discrete : LandingActions::continuous);
  const auto read = [&](const char* name, const std::string& text, learn::QFunction& q) {
    const std::string why = read_weights(text, q.weights());
    if (!why.empty()) setup.explain(std::string(name) + ": " + why + " (weights are written by sinew-learn)");
    return why.empty();
  };
  const bool aside = read("aside", aside_, policy_->aside), down = read("down", down_, policy_->down);
  if (!aside || !down) return hal::Error{hal::Errc::bad_argument, "a learned landing's weights"};
  return {};
}

rt::StepStatus LearnedLanding::step(const rt::Step& step) noexcept {
  const msg::PadSighting* sighting = sighting_.get();
  const msg::NavState* state = state_.fresh(step.now);
  if (!sighting || !sighting_.updated() || !state || !state->attitude_valid) return rt::StepStatus::stale;
  if (!plausible(*state) || (sighting->found != 0 && !within(sighting->direction_optical, 1.001)))
    return rt::StepStatus::fault;
  if (pilot_.see(*sighting, *state)) pilot_.act(policy_->wish(pilot_.view));
  msg::FlightSetpoint& out = guide_.loan();
  out.stamp = sighting->stamp;
  out.v_world_mps = pilot_.velocity_mps().to<msg::Vec3>();
  out.mode = msg::FlightMode::velocity;
  out.armed = 1;
  return rt::StepStatus::ok;
}

}  // namespace sinew::control
