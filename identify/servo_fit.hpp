#pragma once
// A servo's numbers from what was recorded while it moved.
//
//   const ServoFit fit = fit_servo(record);
//   fit.of(ServoParameter::delay).value, .half_width;     // s, 95 %
//   fit.unknown;                                          // what the record does not show, in words
#include <optional>
#include <string>
#include <vector>

#include "identify/servo_model.hpp"

namespace sinew::identify {

/// One joint while it alone moved.
struct ServoRecord {
  CommandLine commands;
  std::vector<double> time_s;  // of the measurements, on the commands' clock; rises
  std::vector<double> position_rad;
  std::vector<double> effort_nm;  // of the motor, before friction; empty or NaN: not measured
};

struct ServoFitOptions {
  double held_out_share = 0.25;  // of the record's end: not fitted, only predicted
  std::size_t parts = 8;         // of the rest, each fitted on its own: how they differ gives the intervals
  double settle_s = 0.5;         // at the beginning of each: the model does not know how it began
  double block_s = 0.25;         // errors further apart than this are taken as independent
  double step_s = 2.5e-4;        // of the model, at most
  /// Numbers that are known. Without measured efforts one torque has to be: the stall torque, if none is named.
  std::vector<std::pair<ServoParameter, double>> known{};
  double typical_stall_nm = 2;             // is where a fit without efforts begins
  std::optional<bool> encoder_at_motor{};  // nothing: what fits better
};

struct ServoEstimate {
  enum class State : std::uint8_t {
    identified,
    known,      // as the caller said
    not_shown,  // the record does not show it, alone or together with others: fit.unknown has the words
  } state = State::not_shown;
  double value = 0, half_width = 0;  // 95 %; 0 for what is known, infinite for what nothing shows
};

/// How far the model is from the measurements, root mean square.
struct ServoError {
  double position_rad = 0, effort_nm = 0;  // effort NaN: not measured
};

struct ServoFit {
  std::string problem;  // empty: it was fitted
  ServoModel model;
  std::array<ServoEstimate, kServoParameters> estimates{};
  std::vector<std::string> unknown;  // what the record does not show, and what would
  ServoError fitted, held_out;
  ServoError moved;        // of the measurements from their mean, in the part held out
  bool side_known = true;  // false: an encoder on the other side of the play fits equally well
  bool doubtful = false;   // the part held out is missed by more than the encoder's steps explain
  int rounds = 0;
  const ServoEstimate& of(ServoParameter p) const { return estimates[static_cast<std::size_t>(p)]; }
};

/// Fits the model's positions and efforts, from several starts and for both sides of the encoder; where that leaves
/// more than the encoder's steps do, from more. Then it fits parts of the record on their own: the numbers are their
/// means, and the intervals are 2.2 or 3 times Student's for means of so many (docs/identify.md says why). They hold
/// also where the model is wrong in small things, whose errors differ from part to part; each part must show all kinds
/// of motion for that. Thread:  owner.   RT: no: some seconds for 40 s. Errors:  `problem`: too short, nothing moved,
/// no commands.
ServoFit fit_servo(const ServoRecord& record, const ServoFitOptions& options = {});

/// A model to begin with: efforts against positions and their derivatives, or typical values where there are no
/// efforts.
ServoModel guess_servo(const ServoRecord& record, const ServoFitOptions& options);

}  // namespace sinew::identify
