#pragma once
#include "msg/flight.hpp"
#include "msg/gait.hpp"
#include "msg/referee.hpp"
#include "msg/team.hpp"
#include "rt/module.hpp"
#include "soccer/world/locator.hpp"

namespace sinew::soccer {

/// Says where on the field the robot is: docs/soccer-world.md.
/// Which half it is in is known from the start, if it begins in its own half; after a penalty, since it comes back over
/// the touch line of its own half; and from balls that it and a mate see.
/// Frames:  pose: "field". nav: the world's axes, as a referee says that they are turned; as "field" without one.
/// Thread:  executor, released by sightings.   RT: yes.
/// Errors:  stale when no picture came, or nothing is known of the gait for 200 ms.
class Locate final : public rt::Module {
 public:
  Locate() : locator_(field_) {}
  void declare(rt::Declaration& d) override;
  void reset() override;
  rt::StepStatus step(const rt::Step& step) noexcept override;

 private:
  struct Heard {
    std::uint32_t penalised = 0, half = 0, attacks_right = 1, spare = 0;
    std::int64_t ends_ns = 0;  // when the teams changed ends
  };
  void heed_referee(rt::Time now);
  void heed_mates();

  const Field field_;
  rt::InQueue<msg::SoccerSight> sight_, sight2_;
  rt::In<msg::GaitState> gait_;
  rt::In<msg::RefereeState> referee_;
  rt::In<msg::BallModel> ball_;
  rt::InQueue<msg::FromMate<msg::SoccerReport>> mates_;
  rt::Out<msg::FieldPose> pose_;
  rt::Out<msg::NavState> nav_;
  bool own_half_ = true;

  Locator locator_;
  Heard heard_;              // state
  std::uint64_t began_ = 0;  // state
};

}  // namespace sinew::soccer
