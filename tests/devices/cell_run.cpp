#include "cell_run.hpp"

#include <algorithm>
#include <cmath>
#include <regex>

namespace sinew::test {
namespace {

constexpr Duration kPatience = 20s, kHealthy = 1s, kFaulty = 5s, kSettles = 1s;

std::string without_numbers(const std::string& text) {
  static const std::regex number("[0-9]+(\\.[0-9]+)?(e[-+][0-9]+)?|\\bN\\b");
  return std::regex_replace(text, number, "#");
}

std::vector<std::string> words(const std::string& text) {
  std::vector<std::string> out;
  static const std::regex word("[0-9]+(\\.[0-9]+)?(e[-+][0-9]+)?|\\bN\\b|[^0-9N]+|N");
  for (auto it = std::sregex_iterator(text.begin(), text.end(), word); it != std::sregex_iterator(); ++it)
    out.push_back(it->str());
  return out;
}

std::string in_ms(Duration d) { return std::to_string((d.count() + 5'000'000) / 10'000'000 * 10) + " ms"; }

}  // namespace

void TextLog::add(const std::string& text) {
  for (std::string& known : texts_) {
    if (known == text) return;
    if (without_numbers(known) != without_numbers(text)) continue;
    const auto a = words(known), b = words(text);
    if (a.size() != b.size()) continue;
    std::string merged;
    for (std::size_t i = 0; i < a.size(); ++i) merged += a[i] == b[i] ? a[i] : "N";
    known = merged;
    return;
  }
  texts_.push_back(text);
}

Cell CellRun::play() {
  rig_ = kind_.make();
  if (at_start(fault_)) rig_->inject(fault_, way_), rig_->advance(rig_->os.now());
  robot_ = std::make_unique<Robot>(*rig_);
  auto failed = robot_->open();
  if (!failed.empty()) {
    EXPECT_TRUE(at_start(fault_)) << "a healthy robot does not start: " << failed.front();
    cannot_start(std::move(failed));
  } else {
    injected_ = rig_->os.now();
    robot_->run(*this);
    check_fault();
  }
  const std::string label = rig_->ways(fault_)[way_].label;
  Cell cell{kind_.title, std::string(to_string(fault_)) + (label.empty() ? "" : ": " + label), {}, "", ""};
  for (const TextLog* log : {&read_, &refused_})
    for (const std::string& text : log->texts()) cell.read.push_back(rig_->as_on_a_robot(text));
  if (cell.read.empty()) cell.read.push_back("nothing");
  cell.guardian = what_guardian_did();
  cell.recovery = recovery_text();
  robot_.reset();
  return cell;
}

// ---- a run that does not start

void CellRun::cannot_start(std::vector<std::string> read) {
  for (const std::string& text : read) read_.add(text);
  check_opening_texts();
  robot_.reset();
  if (!rig_->heals) {
    how_ = "-";
    return;
  }
  rig_->heal();
  rig_->advance(rig_->os.now() + 100ms);
  robot_ = std::make_unique<Robot>(*rig_);
  const auto again = robot_->open();
  EXPECT_TRUE(again.empty()) << "it does not start once it is healed: " << again.front();
  how_ = again.empty() ? "start the run again" : "never";
}

void CellRun::check_opening_texts() {
  std::string all;
  for (const std::string& text : read_.texts()) all += text + "\n";
  EXPECT_NE(all.find("device '" + rig_->device + "'"), std::string::npos) << "names no device: " << all;
  const auto has = [&](const std::string& name) { return all.find(name) != std::string::npos; };
  EXPECT_TRUE(std::any_of(rig_->names.begin(), rig_->names.end(), has)) << "names no path: " << all;
  // Advice to the user: a command, or a thing to look at.
  static const std::regex advice(
      "sudo|usermod|fuser|modprobe|'ip link|ls -l|ls /|\\?|there is: |is there|unbind|stop |has to ");
  EXPECT_TRUE(std::regex_search(all, advice)) << "says nothing that can be done: " << all;
}

// ---- a run

bool CellRun::works() const {
  if (rig_->is_group && (robot_->seen.joints.ready & 3) != 3) return false;
  return robot_->safety().permitted != 0;
}

bool CellRun::at(Time now) {
  ++steps_;
  if (since_.ns == 0) {
    since_ = now;
    if (at_start(fault_)) begin_fault(now);
  }
  const Duration in_stage = now - since_;
  if (stage_ == Stage::warm) {
    if (!robot_->safety().permitted && every(100ms)) robot_->arm();
    if (works()) go(Stage::healthy, now);
  } else if (stage_ == Stage::healthy) {
    if (in_stage >= kHealthy) {
      EXPECT_TRUE(works()) << "healthy, and not permitted any more";
      for (const std::string& text : robot_->complaints()) ADD_FAILURE() << "a healthy device complains: " << text;
      EXPECT_EQ(robot_->seen.old, 0u) << "a healthy device delivers old samples";
      EXPECT_EQ(robot_->seen.same_stamp, 0u);
      rig_->inject(fault_, way_);
      begin_fault(now);
    }
  } else if (stage_ == Stage::faulty) {
    during_fault(now);
    if (in_stage >= kFaulty) end_fault(now);
  } else {
    look_for_recovery(now);
  }
  if (now - since_ <= kPatience) return stage_ != Stage::done && stage_ != Stage::failed;
  if (stage_ == Stage::warm) {
    std::string why;
    for (const std::string& r : robot_->reasons()) why += r + "; ";
    for (const std::string& r : robot_->complaints()) why += r + "; ";
    ADD_FAILURE() << "a healthy robot is not armed: " << why;
  }
  how_ = "never";
  return false;
}

void CellRun::begin_fault(Time now) {
  injected_ = now;
  robot_->seen = {};
  go(Stage::faulty, now);
}

void CellRun::during_fault(Time now) {
  if (every(20ms) && (!at_start(fault_) || now - injected_ > 400ms))
    for (const std::string& text : robot_->complaints()) read_.add(text);
  if (at_start(fault_) && every(100ms) && !robot_->safety().permitted) {
    robot_->arm();
    for (const std::string& text : robot_->reasons()) add_reason(text);
  }
  const std::uint32_t acted = robot_->safety().acted;
  if (acted != 0 && acted_ == 0) acted_at_ = now;
  if (acted != acted_)
    for (const std::string& text : robot_->reasons()) add_reason(text);
  acted_ = acted;
  if (now - injected_ < 1s) {
    in_fault_ = robot_->seen;
    return;
  }
  if (!rig_->is_group) return;
  const msg::JointState& j = robot_->seen.joints;
  const bool own = (j.ready & 1) != 0, other = (j.ready & 2) != 0;
  own_stopped_ = own_stopped_ || !own;
  other_stopped_ = other_stopped_ || !other;
  if (other) farthest_other_ = std::max(farthest_other_, std::abs(j.position_rad[1] - robot_->setpoint));
}

/// The conditions that keep it from being armed. Their values are left out: they differ from run to run.
void CellRun::add_reason(const std::string& text) {
  static const std::regex value("( is | for )-?[0-9.]+(e-?[0-9]+)?( ms)? \\(");
  for (const rt::FailsafeSpec& f : robot_->spec().failsafes)
    if (text.starts_with(f.name + ": ") && text.find("has acted") == std::string::npos)
      refused_.add(std::regex_replace(text, value, "$1N$3 ("));
}

void CellRun::end_fault(Time now) {
  const Seen before = in_fault_;
  in_fault_ = robot_->seen;
  in_fault_.samples -= before.samples, in_fault_.old -= before.old, in_fault_.same_stamp -= before.same_stamp;
  rig_->heal();
  healed_ = now;
  robot_->seen.first = {};
  go(Stage::healed, now);
}

/// Samples first; then, whether commands pass by themselves, after arming, or after disarming and arming.
void CellRun::look_for_recovery(Time now) {
  const Duration in_stage = now - since_;
  const bool poll = every(100ms);
  if (stage_ == Stage::healed) {
    const bool well = robot_->complaints().empty();
    // What a joint was switched off for it says until it is switched on again.
    if (robot_->seen.first.ns == 0 || (!well && !(rig_->is_group && in_stage >= 3s))) return;
    until_enabled_ = !well;
    back_ = now - healed_;
    go(Stage::settled, now);
  } else if (stage_ == Stage::settled) {
    if (works()) how_ = "by itself", go(Stage::done, now);
    if (in_stage < kSettles || works()) return;
    if (robot_->safety().permitted) {
      how_ = "by itself";
      if (in_stage > 10s) how_ = "not while the run goes on", go(Stage::done, now);
      return;
    }
    robot_->arm();
    go(Stage::armed_again, now);
  } else if (stage_ == Stage::armed_again) {
    if (works()) how_ = "`sinew arm`", go(Stage::done, now);
    if (!robot_->safety().permitted && in_stage >= kSettles) {
      robot_->disarm();
      go(Stage::disarmed, now);
    }
  } else if (stage_ == Stage::disarmed) {
    if (works()) how_ = "`sinew disarm`, `sinew arm`", go(Stage::done, now);
    if (!robot_->safety().permitted && poll && in_stage >= 200ms) robot_->arm();
  }
}

// ---- the outcome

void CellRun::check_fault() {
  EXPECT_EQ(in_fault_.old, 0u) << "old data as fresh";
  EXPECT_EQ(in_fault_.same_stamp, 0u) << "one measurement twice";
  EXPECT_NE(how_, "never") << "does not come back";
  EXPECT_NE(how_, "") << "does not come back";
  const bool noticed = !read_.texts().empty() || acted_ != 0 || !refused_.texts().empty();
  const bool harmless = fault_ == Fault::duplicate || fault_ == Fault::slow || rig_->ways(fault_)[way_].harmless;
  EXPECT_TRUE(noticed || harmless) << "nobody notices";
  EXPECT_TRUE(noticed || !own_stopped_) << "a joint goes off, and nobody says why";
  EXPECT_TRUE(robot_->complaints().empty()) << "it works again, and complains: " << robot_->complaints().front();
  if (fault_ == Fault::silent || fault_ == Fault::unplugged || fault_ == Fault::stuck) {
    if (rig_->is_group)
      EXPECT_TRUE(own_stopped_) << "a joint that is lost or stuck counts as ready";
    else
      EXPECT_NE(acted_, 0u) << "no failsafe acted";
  }
  if (acted_ != 0 && !rig_->is_group && how_ != "never") {
    EXPECT_NE(how_, "by itself") << "what a failsafe has stopped goes on by itself";
  }
}

std::string CellRun::other_joint() const {
  if (!rig_->is_group || acted_ != 0) return "";
  EXPECT_LT(farthest_other_, 0.2) << "the other joint does not follow";
  if (other_stopped_) return "";
  char text[80];
  std::snprintf(text, sizeof text, "; the other joint goes on");
  return text;
}

std::string CellRun::what_guardian_did() const {
  if (at_start(fault_) && healed_.ns == 0) return "the run does not start";
  std::string text;
  for (std::size_t i = 0; i < robot_->spec().failsafes.size(); ++i)
    if (acted_ >> i & 1) text += (text.empty() ? "`" : ", `") + robot_->spec().failsafes[i].name + "`";
  if (!text.empty()) text += " stops, first after " + in_ms(acted_at_ - injected_);
  if (text.empty() && at_start(fault_))
    text = refused_.texts().empty() ? "lets it be armed" : "does not let it be armed";
  if (text.empty()) text = "nothing";
  if (rig_->is_group) text += own_stopped_ ? "; the joint is off" : "; the joint goes on";
  return text + other_joint();
}

std::string CellRun::recovery_text() const {
  if (at_start(fault_) && healed_.ns == 0) return how_;
  if (how_ == "never") return how_;
  const std::string device = back_ <= 50ms ? "at once" : "after " + in_ms(back_);
  std::string noticed = read_.texts().empty() && acted_ == 0 ? "" : "the device " + device + "; ";
  if (until_enabled_) noticed = "the device says it until it is enabled again; ";
  return noticed + "commands " + (how_ == "by itself" ? "by themselves" : "after " + how_);
}

}  // namespace sinew::test
