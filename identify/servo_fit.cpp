#include "identify/servo_fit.hpp"

#include <algorithm>
#include <cstdio>

#include "identify/output_error.hpp"
#include "identify/student.hpp"
#include "math/random.hpp"

namespace sinew::identify {
namespace {

constexpr std::size_t kLeastSamples = 200;
constexpr double kLeastMotion_rad = 0.02;
/// The parts' fits begin at one common fit, and the sums of squares are rough: they differ by less than independent
/// fits would. Found on servos with known numbers, docs/identify.md.
double of_common_start(ServoParameter p) {
  const bool damps = p == ServoParameter::viscous || p == ServoParameter::no_load || p == ServoParameter::delay;
  return damps ? 3 : 2.2;  // these three stand for each other: all parts miss them by the same
}
/// The error held out, against that of the encoder's steps: beyond it a fit is doubtful.
constexpr double kExplained = 1.25;
constexpr std::uint64_t kMoreStarts = 4;
/// Of the squared errors held out, by which one side of the play is better: 0.5 and more with 0.1 degrees of play, up
/// to 0.04 without any.
constexpr double kBetterSide = 0.15;

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
    resolution_rad_ = resolution();
  }

  ServoFit run() {
    const ServoModel guess = guess_servo(record_, options_);
    choose_free();
    const Part whole = part_of(record_, first_s_, hold_from_s_, options_.settle_s, options_.block_s);
    std::vector<Candidate> sides;
    for (const bool at_motor : {false, true})
      if (!options_.encoder_at_motor || *options_.encoder_at_motor == at_motor)
        sides.push_back(candidate(whole, best_start(guess, at_motor)));
    const auto best = [&]() -> Candidate& { return *std::min_element(sides.begin(), sides.end(), fits_better); };
    // A fit that is stuck leaves more than the encoder's steps do: again from elsewhere, for both sides.
    for (std::uint64_t again = 1; again <= kMoreStarts && !explains(best()); ++again)
      for (Candidate& side : sides) {
        Candidate other = candidate(whole, other_start(guess, side.model.encoder_at_motor, again));
        if (fits_better(other, side)) side = std::move(other);
      }

    ServoFit result;
    const Candidate& chosen = best();
    result.rounds = chosen.fit.rounds;
    name_unknown(chosen.fit, chosen.model, result);
    fit_parts(chosen.fit, chosen.model, result);
    report_errors(result);
    if (sides.size() == 2) compare_sides(chosen, &chosen == &sides[0] ? sides[1] : sides[0], result);
    judge(result);
    return result;
  }

 private:
  /// A fit of all that is fitted.
  struct Candidate {
    ServoModel model;
    OutputFit fit;
    std::vector<double> position_off, effort_off;  // of the measurements held out
    double held_out = 0;                           // the smaller, the better
  };
  static bool fits_better(const Candidate& a, const Candidate& b) { return a.held_out < b.held_out; }

  Candidate candidate(const Part& whole, const ServoModel& start) const {
    Candidate c;
    c.fit = improve(whole, start, 2 * options_.step_s, 10);
    c.model = with(start, c.fit.value);
    const std::size_t n = record_.time_s.size(), from = index_of(hold_from_s_);
    std::vector<double> position(n), effort(n);
    simulate(c.model, record_, 2 * options_.step_s, position, effort);
    for (std::size_t i = from; i < n; ++i) {
      c.position_off.push_back(record_.position_rad[i] - position[i]);
      if (with_effort_ && !math::is_nan(record_.effort_nm[i])) c.effort_off.push_back(record_.effort_nm[i] - effort[i]);
    }
    c.held_out = math::log(rms_of(c.position_off)) + (c.effort_off.empty() ? 0 : math::log(rms_of(c.effort_off)));
    return c;
  }
  static double rms_of(const std::vector<double>& all) {
    double sum = 0;
    for (const double x : all) sum += x * x;
    return all.empty() ? math::kNan : math::sqrt(sum / static_cast<double>(all.size()));
  }
  bool explains(const Candidate& c) const {
    return !(resolution_rad_ > 0) || rms_of(c.position_off) <= kExplained * resolution_rad_ / math::sqrt(12.0);
  }
  std::size_t index_of(double t) const {
    return static_cast<std::size_t>(std::lower_bound(record_.time_s.begin(), record_.time_s.end(), t) -
                                    record_.time_s.begin());
  }
  /// The smallest step between two positions.
  double resolution() const {
    std::vector<double> sorted = record_.position_rad;
    std::sort(sorted.begin(), sorted.end());
    std::vector<double> steps;
    for (std::size_t i = 1; i < sorted.size(); ++i)
      if (sorted[i] - sorted[i - 1] > 1e-9) steps.push_back(sorted[i] - sorted[i - 1]);
    if (steps.empty()) return 0;
    // Of an encoder most values are taken several times, and most neighbours are one step apart.
    if (steps.size() * 2 > sorted.size()) return 0;
    std::nth_element(steps.begin(), steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 4), steps.end());
    return steps[steps.size() / 4];
  }

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

  /// The best of many models around the guess, each run once, and improved.
  ServoModel other_start(const ServoModel& guess, bool at_motor, std::uint64_t again) const {
    constexpr int kDraws = 60;
    constexpr double kBegin = 0.25;  // of what is fitted
    math::Random random(again, at_motor ? 0x6d6f746f : 0x6a6f696e);
    const Part begin =
        part_of(record_, first_s_, first_s_ + kBegin * (hold_from_s_ - first_s_), options_.settle_s, options_.block_s);
    const auto times = [&](double most) { return math::exp(random.uniform(-1, 1) * math::log(most)); };
    ServoModel best = guess;
    double least = math::kInf;
    std::vector<double> position(begin.record.time_s.size()), effort(position.size());
    for (int k = 0; k < kDraws; ++k) {
      ServoModel m = guess;
      m.encoder_at_motor = at_motor;
      for (const ServoParameter p : free_) {
        double& x = number(m, p);
        if (p == ServoParameter::delay)
          x = random.uniform(0, 0.04);
        else if (p == ServoParameter::play)
          x = 0.002 * times(5);
        else if (p == ServoParameter::rotor)
          x = random.uniform(0.1, 0.7) * m.inertia_kgm2;
        else if (p == ServoParameter::gain || p == ServoParameter::coulomb || p == ServoParameter::inertia)
          x *= times(1.5);
        else if (p == ServoParameter::stall || p == ServoParameter::no_load)
          x *= times(1.15);
      }
      simulate(m, begin.record, 4 * options_.step_s, position, effort);
      std::vector<double> off, off_nm;
      for (std::size_t i = 0; i < position.size(); ++i) {
        off.push_back(math::fabs(begin.record.position_rad[i] - position[i]));
        if (with_effort_ && !math::is_nan(begin.record.effort_nm[i]))
          off_nm.push_back(math::fabs(begin.record.effort_nm[i] - effort[i]));
      }
      const double size = math::log(rms_of(off)) + (off_nm.empty() ? 0 : math::log(rms_of(off_nm)));
      if (size < least) least = size, best = m;
    }
    const OutputFit coarse = improve(begin, best, 4 * options_.step_s, 8, nullptr, true);
    best = with(best, coarse.value);
    return with(best, improve(begin, best, 3 * options_.step_s, 10).value);
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
  void compare_sides(const Candidate& chosen, const Candidate& other, ServoFit& result) const;
  void judge(ServoFit& result) const;

  const ServoRecord& record_;
  const ServoFitOptions& options_;
  bool with_effort_ = false;
  double first_s_ = 0, hold_from_s_ = 0;
  double resolution_rad_ = 0;  // of the encoder; 0: it has no steps
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
    e.half_width = of_common_start(p) * student_95(n - 1) * math::sqrt(square / (n - 1) / n);
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
  const std::size_t fitted = index_of(hold_from_s_);
  result.fitted = in(index_of(first_s_ + options_.settle_s), fitted);
  result.held_out = in(fitted, n);
  double mean = 0, mean_nm = 0;
  for (std::size_t i = fitted; i < n; ++i) mean += record_.position_rad[i] / static_cast<double>(n - fitted);
  if (with_effort_)
    for (std::size_t i = fitted; i < n; ++i) mean_nm += record_.effort_nm[i] / static_cast<double>(n - fitted);
  result.moved = {
      rms(fitted, n, [&](std::size_t i) { return record_.position_rad[i] - mean; }),
      with_effort_ ? rms(fitted, n, [&](std::size_t i) { return record_.effort_nm[i] - mean_nm; }) : math::kNan};
}

/// Whether the better one is better by more than chance, from stretches of the part held out.
void ServoFitter::compare_sides(const Candidate& chosen, const Candidate& other, ServoFit& result) const {
  const std::size_t n = chosen.position_off.size(), from = index_of(hold_from_s_);
  const double sigma = rms_of(chosen.position_off), sigma_nm = rms_of(chosen.effort_off);
  std::vector<double> blocks;
  double begin_s = hold_from_s_ - 1;
  for (std::size_t i = 0; i < n; ++i) {
    if (record_.time_s[from + i] - begin_s >= options_.block_s) begin_s = record_.time_s[from + i], blocks.push_back(0);
    const auto worse = [&](const std::vector<double>& a, const std::vector<double>& b, double scale) {
      return i < a.size() ? (b[i] * b[i] - a[i] * a[i]) / (scale * scale) : 0;
    };
    blocks.back() +=
        worse(chosen.position_off, other.position_off, sigma) + worse(chosen.effort_off, other.effort_off, sigma_nm);
  }
  double mean = 0, square = 0;
  const double count = static_cast<double>(blocks.size());
  for (const double b : blocks) mean += b / count;
  for (const double b : blocks) square += (b - mean) * (b - mean);
  // Fits that end in neighbouring minima differ a little, whatever is true.
  const double share = mean * count / static_cast<double>(n + chosen.effort_off.size());
  result.side_known =
      count > 2 && share > kBetterSide && mean > student_95(count - 1) * math::sqrt(square / (count - 1) / count);
  if (!result.side_known)
    result.unknown.push_back("the encoder's side of the play: at the joint or at the motor, both fit equally well");
}

void ServoFitter::judge(ServoFit& result) const {
  const double steps_rad = resolution_rad_ / math::sqrt(12.0);
  result.doubtful = steps_rad > 0 && result.held_out.position_rad > kExplained * steps_rad;
  if (!result.doubtful) return;
  char text[200];
  std::snprintf(text, sizeof text,
                "whether the fit is stuck or the model lacks something: it misses the part held out by %.1f times what "
                "the encoder's steps alone make; numbers and intervals may be wrong",
                result.held_out.position_rad / steps_rad);
  result.unknown.push_back(text);
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
