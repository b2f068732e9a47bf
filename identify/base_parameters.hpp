#pragma once
// Base inertial parameters: what of a body's masses, and of its joints' friction, measured efforts can tell.
#include <string>
#include <vector>

#include "identify/chain_regressor.hpp"

namespace sinew::identify {

/// A parameter of the efforts that stands alone, with those that cannot be told from it: value = parameter of `column`
/// + the sum of factor * parameter of each in `with`.
struct BaseColumn {
  std::size_t column = 0;
  struct Part {
    std::size_t column = 0;
    double factor = 0;
  };
  std::vector<Part> with{};
};

/// Which parameters of a body efforts can tell at all, whatever the motion.
struct BaseSet {
  std::vector<BaseColumn> base;
  std::vector<std::size_t> without_effect;  // columns that change no effort
};

/// Source:  M. Gautier, Numerical calculation of the base inertial parameters of robots (1991): columns of the
///          regressor at random motions that depend on those before them are grouped with these.
BaseSet base_set(const kinematics::Body& body, const math::Vec3& gravity_mps2);

/// "pelvis.mx + 0.09 shin.m", with at most `most` terms.
std::string base_name(const kinematics::Body& body, const BaseColumn& base, std::size_t most = 4);

/// Joints that were measured while they moved: row i was measured at time_s[i], which rises.
struct ChainRecord {
  std::vector<double> time_s;
  // For each joint of the body, as long as time_s. Effort: of the motor, before the gear's friction.
  std::vector<std::vector<double>> q_rad, effort_nm;
};

struct BaseOptions {
  math::Vec3 gravity_mps2{0, 0, -9.80665};  // in link 0's frame
  double window_s = 0.03;       // standard deviation of the low-pass that efforts and all that they are of go through
  double least_radps = 0.05;    // a joint that is slower for a fifth of it does not count: friction at rest is any
  double held_out_share = 0.2;  // of the record's end
  double block_s = 0.3;  // residuals of different blocks are taken as independent: more than the low-pass's length
};

struct BaseEstimate {
  double value = 0, half_width = 0;  // 95 %
  bool identified = true;  // false: within its interval the efforts differ by more than a fifth of what was measured
};

struct BaseFit {
  BaseSet set;
  std::vector<BaseEstimate> estimates;                                  // of set.base
  std::vector<double> effort_rms_nm, residual_rms_nm, held_out_rms_nm;  // of each joint
  std::size_t rows = 0;
  std::string problem;  // empty: it was solved
};

/// Least squares of the efforts, each joint weighted by its own residuals; the intervals are those of residuals that
/// depend on each other within a block. The speed at which half of a joint's Coulomb friction is there is fitted, too,
/// and not given.
/// Source:  J. Swevers, W. Verdonck, J. De Schutter, Dynamic model identification for industrial robots (2007);
///          M. Gautier, Dynamic identification of robots with power model (1997): both sides through one low-pass;
///          H. White, A heteroskedasticity-consistent covariance matrix estimator (1980), for blocks.
/// Thread:  any.   RT: no.
BaseFit fit_base_parameters(const kinematics::Body& body, const ChainRecord& record, const BaseOptions& options = {});

}  // namespace sinew::identify
