#include "identify/servo_fit.hpp"

#include <algorithm>
#include <cstdio>

#include "identify/output_error.hpp"
#include "identify/student.hpp"

namespace sinew::identify {
namespace {

constexpr std::size_t kLeastSamples = 200;
constexpr double kLeastMotion_rad = 0.02;
/// The parts' fits begin at one common fit, and the sums of squares are rough: they differ by less than independent
/// fits would. Found on servos with known numbers, docs/identify.md.
constexpr double kOfCommonStart = 3;

/// Positions depend on ratios of torques alone: what is a torque for something is fitted as a share of the stall
/// torque.
bool is_share(ServoParameter p) {
  switch (p) {
    case ServoParameter::inertia:
    case ServoParameter::rotor:
    case ServoParameter::coulomb:
    case ServoParameter::viscous:
    case ServoParameter::gravity_cos:
    case ServoParameter::gravity_sin:
    case ServoParameter::effort_offset:
      return true;
    default:
      return false;
  }
}

double& number(ServoModel& m, ServoParameter p) { return m.*servo_parameters()[static_cast<std::size_t>(p)].value; }
double number(const ServoModel& m, ServoParameter p) {
  return m.*servo_parameters()[static_cast<std::size_t>(p)].value;
}

/// Bounds, steps and scales of a number, or of its share, around its start.
FreeParameter free_parameter(ServoParameter p, const ServoModel& m) {
  const double value = is_share(p) ? number(m, p) / m.stall_nm : number(m, p);
  const double inertia = m.inertia_kgm2 / m.stall_nm, brake = 1 / m.no_load_radps;
  switch (p) {
    case ServoParameter::delay:
      return {value, 0, 0.3, 3e-4, 0.005};
    case ServoParameter::gain:
    case ServoParameter::stall:
    case ServoParameter::no_load:
    case ServoParameter::limit:
      return {value, 0.05 * value, 30 * value, 3e-3 * value, value};
    case ServoParameter::inertia:
      return {value, 0.02 * value, 50 * value, 0.01 * value, value};
    case ServoParameter::rotor:
      return {value, 1e-3 * inertia, 0.98 * inertia, 0.02 * inertia, 0.3 * inertia};
    case ServoParameter::coulomb:
      return {value, 0, 1, 0.02 * std::max(value, 0.01), std::max(value, 0.01)};
    case ServoParameter::slow:
      return {value, 1e-3, 0.5, 0.1 * value, 0.1};
    case ServoParameter::viscous:
      return {value, 0, 10 * brake, 3e-3 * brake, 0.05 * brake};
    case ServoParameter::gravity_cos:
    case ServoParameter::gravity_sin:
      return {value, -20, 20, 2e-3, 0.05};
    case ServoParameter::play:
      return {value, 0, 0.1, 2e-4, 0.002};
    case ServoParameter::effort_offset:
      return {value, -1, 1, 1e-3, 0.05};
  }
  return {};
}

/// A part of a record as outputs to be fitted: positions, and efforts behind them.
struct Part {
  ServoRecord record;  // of the part, with what came shortly before
  OutputProblem problem;
};

/// Measurements from `from_s` until `until_s`; those in the first `settle_s` do not count.
Part part_of(const ServoRecord& r, double from_s, double until_s, double settle_s, double block_s) {
  Part part;
  ServoRecord& p = part.record;
  const auto index = [&](const std::vector<double>& time, double t) {
    return static_cast<std::size_t>(std::lower_bound(time.begin(), time.end(), t) - time.begin());
  };
  constexpr double kLongestDelay_s = 0.3;
  for (std::size_t i = index(r.commands.time_s, from_s - kLongestDelay_s); i < index(r.commands.time_s, until_s); ++i) {
    p.commands.time_s.push_back(r.commands.time_s[i]);
    p.commands.target_rad.push_back(r.commands.target_rad[i]);
  }
  const std::size_t first = index(r.time_s, from_s), end = index(r.time_s, until_s);
  for (std::size_t i = first; i < end; ++i) {
    p.time_s.push_back(r.time_s[i]);
    p.position_rad.push_back(r.position_rad[i]);
    if (!r.effort_nm.empty()) p.effort_nm.push_back(r.effort_nm[i]);
  }
  OutputProblem& o = part.problem;
  o.channels = r.effort_nm.empty() ? 1 : 2;
  for (std::size_t c = 0; c < o.channels; ++c)
    for (std::size_t i = 0; i < p.time_s.size(); ++i) {
      const double t = p.time_s[i] - from_s;
      o.measured.push_back(t < settle_s ? math::kNan : c == 0 ? p.position_rad[i] : p.effort_nm[i]);
      o.channel.push_back(static_cast<std::uint32_t>(c));
      o.block.push_back(static_cast<std::uint32_t>(std::max(t, 0.0) / block_s));
      o.blocks = std::max<std::size_t>(o.blocks, o.block.back() + 1u);
    }
  return part;
}

class ServoFitter {
 public:
  ServoFitter(const ServoRecord& record, const ServoFitOptions& options)
      : record_(record), options_(options), with_effort_(!record.effort_nm.empty()) {
    first_s_ = record.time_s.front();
    hold_from_s_ = record.time_s.back() - options.held_out_share * (record.time_s.back() - first_s_);
  }

  ServoFit run() {
    const ServoModel guess = guess_servo(record_, options_);
    choose_free();
    const Part whole = part_of(record_, first_s_, hold_from_s_, options_.settle_s, options_.block_s);
    ServoModel model = guess;
    OutputFit pooled;
    double least = math::kInf;
    for (const bool at_motor : {false, true}) {
      if (options_.encoder_at_motor && *options_.encoder_at_motor != at_motor) continue;
      const ServoModel start = best_start(guess, at_motor);
      OutputFit fit = improve(whole, start, 2 * options_.step_s, 10);
      const double size = size_of(fit);
      if (size >= least) continue;
      least = size, model = with(start, fit.value), pooled = std::move(fit);
    }

    ServoFit result;
    result.rounds = pooled.rounds;
    name_unknown(pooled, model, result);
    fit_parts(pooled, model, result);
    report_errors(result);
    return result;
  }

 private:
  void choose_free() {
    const auto is_known = [&](ServoParameter p) {
      return std::any_of(options_.known.begin(), options_.known.end(), [&](const auto& k) { return k.first == p; });
    };
    const bool torque_known =
        std::any_of(options_.known.begin(), options_.known.end(), [](const auto& k) { return is_share(k.first); });
    for (std::size_t i = 0; i < kServoParameters; ++i) {
      const auto p = static_cast<ServoParameter>(i);
      if (is_known(p) || p == ServoParameter::limit) continue;
      if (!with_effort_ && p == ServoParameter::effort_offset) continue;
      if (!with_effort_ && p == ServoParameter::stall && !torque_known) continue;
      free_.push_back(p);
    }
  }
  bool is_free(ServoParameter p) const { return std::find(free_.begin(), free_.end(), p) != free_.end(); }

  /// Values are shares of the stall torque where is_share(). Numbers that are known stay what they are.
  ServoModel with(ServoModel model, std::span<const double> value) const {
    for (std::size_t i = 0; i < free_.size(); ++i)
      if (free_[i] == ServoParameter::stall) model.stall_nm = value[i];
    for (std::size_t i = 0; i < free_.size(); ++i)
      number(model, free_[i]) = is_share(free_[i]) ? value[i] * model.stall_nm : value[i];
    return model;
  }

  /// For fits of the same outputs: the smaller, the likelier.
  static double size_of(const OutputFit& fit) {
    double sum = 0;
    for (const double sigma : fit.sigma) sum += math::log(sigma);
    return sum;
  }

  /// Short fits of the record's beginning with little and with much play: first of what moves the joint most, then of
  /// all.
  ServoModel best_start(const ServoModel& guess, bool at_motor) const {
    constexpr double kBegin = 0.4;  // of what is fitted
    const Part begin =
        part_of(record_, first_s_, first_s_ + kBegin * (hold_from_s_ - first_s_), options_.settle_s, options_.block_s);
    ServoModel best = guess;
    double least = math::kInf;
    for (const double play_rad : {0.0015, 0.006}) {
      ServoModel start = guess;
      start.encoder_at_motor = at_motor;
      if (is_free(ServoParameter::play)) start.play_rad = play_rad;
      const OutputFit coarse = improve(begin, start, 4 * options_.step_s, 5, nullptr, true);
      start = with(start, coarse.value);
      const OutputFit fit = improve(begin, start, 3 * options_.step_s, 8);
      const double size = size_of(fit);
      if (size < least) least = size, best = with(start, fit.value);
      if (!is_free(ServoParameter::play)) break;
    }
    return best;
  }

  void simulate(const ServoModel& m, const ServoRecord& r, double step_s, std::span<double> position_rad,
                std::span<double> effort_nm) const {
    m.run(r.commands, {.first_rad = r.position_rad[0], .step_s = step_s}, r.time_s, position_rad, effort_nm);
  }

  OutputFit improve(const Part& part, const ServoModel& start, double step_s, int rounds,
                    const OutputFit* before = nullptr, bool coarse = false) const {
    std::vector<FreeParameter> parameters;
    for (std::size_t i = 0; i < free_.size(); ++i) {
      parameters.push_back(free_parameter(free_[i], start));
      FreeParameter& p = parameters.back();
      const bool fine = free_[i] == ServoParameter::play || free_[i] == ServoParameter::rotor ||
                        free_[i] == ServoParameter::slow || free_[i] == ServoParameter::viscous;
      if (coarse && fine) p.least = p.most = p.value;
      if (!before) continue;
      // Derivatives over about the uncertainty: the errors are rough in what is smaller.
      const double sigma = math::sqrt(before->covariance(i, i));
      if (sigma < math::kInf) p.step = std::clamp(5 * sigma, 0.02 * p.step, p.step);
      if (before->at_bound[i]) p.least = p.most = p.value;
    }
    const std::size_t n = part.record.time_s.size();
    std::vector<double> no_effort(with_effort_ ? 0 : n);
    OutputProblem problem = part.problem;
    problem.run = [&](std::span<const double> value, std::span<double> out) {
      simulate(with(start, value), part.record, step_s, out.first(n),
               with_effort_ ? out.subspan(n) : std::span<double>(no_effort));
    };
    OutputFitOptions options;
    options.most_rounds = rounds;
    options.both_sides = before != nullptr;  // the last fits
    return fit_outputs(problem, parameters, options);
  }

  void name_unknown(const OutputFit& fit, const ServoModel& model, ServoFit& result) const;
  void fit_parts(const OutputFit& pooled, const ServoModel& model, ServoFit& result) const;
  void report_errors(ServoFit& result) const;

  const ServoRecord& record_;
  const ServoFitOptions& options_;
  bool with_effort_ = false;
  double first_s_ = 0, hold_from_s_ = 0;
  std::vector<ServoParameter> free_;
};

/// Each part of the record on its own; the numbers are the parts' means, the intervals come from how the parts differ.
void ServoFitter::fit_parts(const OutputFit& pooled, const ServoModel& model, ServoFit& result) const {
  std::vector<ServoModel> found;
  const double part_s = (hold_from_s_ - first_s_) / static_cast<double>(options_.parts);
  for (std::size_t k = 0; k < options_.parts; ++k) {
    const double from_s = first_s_ + static_cast<double>(k) * part_s;
    const double warm_s = k == 0 ? 0 : std::min(options_.settle_s, part_s);
    const Part part = part_of(record_, from_s - warm_s, from_s + part_s, options_.settle_s, options_.block_s);
    if (part.record.time_s.size() < 4 * free_.size() || part.record.commands.time_s.empty()) continue;
    const OutputFit fit = improve(part, model, options_.step_s, 8, &pooled);
    found.push_back(with(model, fit.value));
  }
  result.model = model;
  const double n = static_cast<double>(found.size());
  for (const ServoParameter p : free_) {
    ServoEstimate& e = result.estimates[static_cast<std::size_t>(p)];
    if (n < 3) {
      e.half_width = math::kInf;
      continue;
    }
    double sum = 0, square = 0;
    for (const ServoModel& m : found) sum += number(m, p) / n;
    for (const ServoModel& m : found) square += (number(m, p) - sum) * (number(m, p) - sum);
    e.value = sum;
    e.half_width = kOfCommonStart * student_95(n - 1) * math::sqrt(square / (n - 1) / n);
    number(result.model, p) = sum;
  }
}

void ServoFitter::name_unknown(const OutputFit& fit, const ServoModel& model, ServoFit& result) const {
  const auto& text = servo_parameters();
  for (std::size_t i = 0; i < kServoParameters; ++i)
    result.estimates[i] = {ServoEstimate::State::known, model.*text[i].value, 0};
  result.estimates[static_cast<std::size_t>(ServoParameter::limit)].state = ServoEstimate::State::not_shown;
  for (const ServoParameter p : free_)
    result.estimates[static_cast<std::size_t>(p)].state = ServoEstimate::State::identified;
  const auto name = [&](std::size_t i) { return std::string(text[static_cast<std::size_t>(free_[i])].name); };
  for (const OutputFit::Weak& weak : fit.weak) {
    std::string names;
    std::size_t count = 0;
    for (std::size_t i = 0; i < free_.size(); ++i) {
      if (math::fabs(weak.parts[i]) < 0.3) continue;
      names += (count++ ? ", " : "") + name(i);
      result.estimates[static_cast<std::size_t>(free_[i])].state = ServoEstimate::State::not_shown;
    }
    result.unknown.push_back(count == 1 ? names + ": this record does not show it"
                                        : names + ": only together, not each of them");
  }
  for (std::size_t i = 0; i < free_.size(); ++i)
    if (fit.at_bound[i]) {
      ServoEstimate& e = result.estimates[static_cast<std::size_t>(free_[i])];
      e.state = ServoEstimate::State::not_shown;
      char number_text[32];
      std::snprintf(number_text, sizeof number_text, "%.4g", e.value);
      result.unknown.push_back(name(i) + ": fits best at its bound, " + number_text);
    }
  if (!with_effort_)
    result.unknown.push_back(
        "the size of all torques: no efforts were recorded; they are relative to the stall torque or to what is known");
}

void ServoFitter::report_errors(ServoFit& result) const {
  const std::size_t n = record_.time_s.size();
  std::vector<double> position(n), effort(n);
  simulate(result.model, record_, options_.step_s, position, effort);
  const auto rms = [&](std::size_t from, std::size_t until, auto&& error) {
    double sum = 0, count = 0;
    for (std::size_t i = from; i < until; ++i) {
      const double e = error(i);
      if (math::is_nan(e)) continue;
      sum += e * e, count += 1;
    }
    return count > 0 ? math::sqrt(sum / count) : math::kNan;
  };
  const auto in = [&](std::size_t from, std::size_t until) {
    return ServoError{
        rms(from, until, [&](std::size_t i) { return record_.position_rad[i] - position[i]; }),
        with_effort_ ? rms(from, until, [&](std::size_t i) { return record_.effort_nm[i] - effort[i]; }) : math::kNan};
  };
  const auto index = [&](double t) {
    return static_cast<std::size_t>(std::lower_bound(record_.time_s.begin(), record_.time_s.end(), t) -
                                    record_.time_s.begin());
  };
  const std::size_t fitted = index(hold_from_s_);
  result.fitted = in(index(first_s_ + options_.settle_s), fitted);
  result.held_out = in(fitted, n);
  double mean = 0, mean_nm = 0;
  for (std::size_t i = fitted; i < n; ++i) mean += record_.position_rad[i] / static_cast<double>(n - fitted);
  if (with_effort_)
    for (std::size_t i = fitted; i < n; ++i) mean_nm += record_.effort_nm[i] / static_cast<double>(n - fitted);
  result.moved = {
      rms(fitted, n, [&](std::size_t i) { return record_.position_rad[i] - mean; }),
      with_effort_ ? rms(fitted, n, [&](std::size_t i) { return record_.effort_nm[i] - mean_nm; }) : math::kNan};
}

}  // namespace

ServoFit fit_servo(const ServoRecord& record, const ServoFitOptions& options) {
  ServoFit result;
  const auto fail = [&](const char* why) {
    result.problem = why;
    return result;
  };
  if (record.time_s.size() != record.position_rad.size() ||
      (!record.effort_nm.empty() && record.effort_nm.size() != record.time_s.size()) ||
      record.commands.time_s.size() != record.commands.target_rad.size())
    return fail("times and values are not as many");
  if (record.time_s.size() < kLeastSamples) return fail("fewer than 200 measurements");
  if (record.commands.time_s.empty()) return fail("no commands");
  const auto [low, high] = std::minmax_element(record.position_rad.begin(), record.position_rad.end());
  if (!(*high - *low > kLeastMotion_rad)) return fail("the joint moved by less than 0.02 rad");
  return ServoFitter(record, options).run();
}

}  // namespace sinew::identify
