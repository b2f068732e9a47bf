#pragma once
// Zeros of joints and heights of soles of a body that stood still in several poses, both feet flat on the ground, and
// saw a board that lies on it.
//
//   StandRecord record{&body, camera, *body.find_place("camera")};
//   record.poses = ...;                        // means over the time in which it stood still
//   const StandFit fit = fit_stand(record);
//   fit.estimates[3].value_rad;                // what joint 3's encoder reads where the joint is at 0
//
// Frames:  board: x along its rows, y down its columns, z into the ground; its surface is the ground.
// Thread:  any.   RT: no, it allocates.
#include <array>
#include <string>
#include <vector>

#include "identify/camera_fit.hpp"
#include "kinematics/body.hpp"

namespace sinew::identify {

struct StandPose {
  std::vector<double> joints_rad;  // as measured, in the body's order
  PlaneView view;                  // the board's corners
  math::Vec3 accel_mps2;           // of the place "imu", in its axes; 0: not measured
};

struct StandRecord {
  const kinematics::Body* body = nullptr;  // has places l_sole, r_sole, and for accelerations imu
  LensCamera camera;                       // its numbers count as exact
  kinematics::Place camera_place;          // x forward, y left, z up
  std::vector<StandPose> poses{};
};

struct StandEstimate {
  std::string name;       // of the joint; "l_sole", "r_sole": how much thicker a sole is
  double value = 0;       // rad; m
  double half_width = 0;  // of the 95 % interval
  bool shown = true;      // false: the half-width is more than `open_rad` or `open_m`
};

struct StandFitOptions {
  double joint_sigma_rad = 5e-4;  // of a measured angle: steps of the encoder, and what gives behind it
  double pixel_sigma_px = 0.12;   // of a corner's coordinate
  double flat_sigma_m = 1e-4, flat_sigma_rad = 6e-4;  // of a sole from flat on the ground
  double slip_sigma_m = 7e-4, slip_sigma_rad = 3e-3;  // and on it from where it is in the mean
  double accel_sigma = 2e-3;                          // of gravity's direction, rad
  double common_rad = 1.75e-3;  // of a zero, 95 %: what is wrong in all poses alike, which their scatter does not show
  double open_rad = 0.0175, open_m = 0.005;
};

struct StandFit {
  std::string problem;                   // empty: all that follows is there
  std::vector<StandEstimate> estimates;  // joints of legs and head in the body's order, then both soles
  std::vector<std::string> unknown;      // what the poses do not show, in words
  std::size_t poses = 0;
  /// Where the camera's axis meets the ground is off by so much, RMS over the poses, of what the board says: with the
  /// joints as they were measured (after the best place and heading of the feet), and with the zeros taken off.
  double before_rad = 0, after_rad = 0;
};

/// Feet slip little from pose to pose; where each is on the ground, and how the IMU is tilted in the body, are found
/// with the zeros. A zero of an ankle has the tilt of its sole in it: no such record tells them apart, and flat soles
/// need only the sum.
/// Intervals come from fit_outputs(): poses are the blocks.
/// Errors:  `problem`: fewer than 26 poses, a view that shows no pose of the board, a body without feet.
StandFit fit_stand(const StandRecord& record, const StandFitOptions& options = {});

/// The body with these zeros taken off measured angles; and its soles as thick as they are.
std::vector<double> corrected(const StandFit& fit, const kinematics::Body& body, std::span<const double> measured_rad);

}  // namespace sinew::identify
