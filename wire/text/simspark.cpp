#include "wire/text/simspark.hpp"

#include <algorithm>

#include "wire/text/usarsim.hpp"  // parse_number(), write_fixed()
#include "wire/text_scan.hpp"

namespace sinew::wire {
namespace {

constexpr std::size_t kHead = 4;  // bytes of the length
constexpr int kDecimals = 6;      // of what an agent commands

/// The words and parentheses of a text, one after the other.
class Tokens {
 public:
  enum class Kind : std::uint8_t { open, close, word, end, bad };

  explicit Tokens(std::string_view text) noexcept : rest_(text) {}

  Kind next() noexcept {
    while (!rest_.empty() && is_blank(rest_.front())) rest_.remove_prefix(1);
    if (rest_.empty()) return Kind::end;
    const char c = rest_.front();
    if (c == '(' || c == ')') {
      rest_.remove_prefix(1);
      return c == '(' ? Kind::open : Kind::close;
    }
    std::size_t n = 0;
    while (n < rest_.size() && is_text(rest_[n])) ++n;
    if (n == 0) return Kind::bad;
    word_ = rest_.substr(0, n);
    rest_.remove_prefix(n);
    return Kind::word;
  }
  std::string_view word() const noexcept { return word_; }
  std::string_view rest() const noexcept { return rest_; }

 private:
  static bool is_blank(char c) noexcept { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }
  static bool is_text(char c) noexcept { return c > ' ' && c < 0x7F && c != '(' && c != ')'; }

  std::string_view rest_, word_;
};

/// One "(name words... (child ...)...)" as it is walked through. The children are read in their order.
class List {
 public:
  /// Of a text that begins behind "(": empty `name`: an error.
  List(Tokens& tokens, SparkError& error, std::size_t depth) noexcept : tokens_(tokens), error_(error), depth_(depth) {
    if (depth_ > kSparkDepth) {
      fail(SparkError::depth);
      return;
    }
    if (step() == Tokens::Kind::word) {
      name = tokens_.word();
      step();
    }
  }
  List(const List&) = delete;
  List& operator=(const List&) = delete;

  std::string_view name;

  bool at_word() const noexcept { return at_ == Tokens::Kind::word; }
  bool at_child() const noexcept { return at_ == Tokens::Kind::open; }
  bool at_end() const noexcept { return at_ == Tokens::Kind::close || error_ != SparkError::none; }

  /// The next word; empty with an error when there is none.
  std::string_view word() noexcept {
    if (!at_word()) {
      fail(SparkError::missing);
      return {};
    }
    const std::string_view found = tokens_.word();
    step();
    return found;
  }
  /// Without taking it; empty: there is none.
  std::string_view word_ahead() const noexcept { return at_word() ? tokens_.word() : std::string_view(); }
  double number() noexcept {
    const std::string_view text = word();
    if (error_ != SparkError::none) return 0;
    const auto value = parse_number(text);
    if (!value) fail(SparkError::number);
    return value.value_or(0);
  }
  std::uint32_t count() noexcept {
    const std::string_view text = word();
    if (error_ != SparkError::none) return 0;
    const auto value = parse_decimal(text, 9);
    if (!value) fail(SparkError::number);
    return static_cast<std::uint32_t>(value.value_or(0));
  }
  template <std::size_t N>
  void numbers(std::array<double, N>& out) noexcept {
    for (double& value : out) value = number();
  }
  /// Calls read(List&) for the child that comes next, and skips what it left.
  template <class Read>
  void child(Read&& read) noexcept {
    List inner(tokens_, error_, depth_ + 1);
    if (error_ == SparkError::none) read(inner);
    inner.skip();
    if (error_ == SparkError::none) step();
  }
  /// For all words and children that are left: words are passed over.
  template <class Read>
  void children(Read&& read) noexcept {
    while (!at_end()) {
      if (at_child())
        child(read);
      else
        step();
    }
  }
  void skip() noexcept {
    children([](List&) {});
  }
  void fail(SparkError error) noexcept {
    if (error_ == SparkError::none) error_ = error;
  }

 private:
  Tokens::Kind step() noexcept {
    at_ = tokens_.next();
    if (at_ == Tokens::Kind::end) fail(SparkError::parenthesis);
    if (at_ == Tokens::Kind::bad) fail(SparkError::text);
    return at_;
  }

  Tokens& tokens_;
  SparkError& error_;
  const std::size_t depth_;
  Tokens::Kind at_ = Tokens::Kind::end;
};

/// Calls read(List&) for each expression of a message.
template <class Read>
SparkError each_expression(Tokens& tokens, Read&& read) noexcept {
  SparkError error = SparkError::none;
  while (error == SparkError::none) {
    switch (tokens.next()) {
      case Tokens::Kind::end:
        return error;
      case Tokens::Kind::close:
        return SparkError::parenthesis;
      case Tokens::Kind::word:
      case Tokens::Kind::bad:
        return SparkError::text;
      case Tokens::Kind::open:
        break;
    }
    List list(tokens, error, 1);
    if (error == SparkError::none && !read(list)) return error;
    list.skip();
  }
  return error;
}

/// The next free place of an array; null with an error when there is none.
template <class T, std::size_t N>
T* place_in(std::array<T, N>& all, std::size_t& used, List& list) noexcept {
  if (used == N) {
    list.fail(SparkError::too_many);
    return nullptr;
  }
  all[used] = {};
  return &all[used++];
}

SparkPolar polar_of(List& list) noexcept {
  SparkPolar polar;
  polar.distance_m = list.number();
  polar.azimuth_deg = list.number();
  polar.elevation_deg = list.number();
  return polar;
}

void read_game(List& list, SparkPercepts& out) noexcept {
  out.has_game = true;
  list.children([&](List& part) {
    if (part.name == "unum") out.number = part.count();
    if (part.name == "team") out.side = part.word();
    if (part.name == "sl") out.left_goals = part.count();
    if (part.name == "sr") out.right_goals = part.count();
    if (part.name == "t") out.game_s = part.number();
    if (part.name == "pm") out.play_mode = part.word();
    if (part.name == "tl") out.left_team = part.word_ahead();
    if (part.name == "tr") out.right_team = part.word_ahead();
  });
}

/// The vector in the part called `name`; false: there is none.
bool read_vector(List& list, std::string_view name, std::array<double, 3>& out) noexcept {
  bool found = false;
  list.children([&](List& part) {
    if (part.name != name) return;
    part.numbers(out);
    found = true;
  });
  if (!found) list.fail(SparkError::missing);
  return found;
}

void read_joint(List& list, SparkPercepts& out) noexcept {
  SparkJoint* joint = place_in(out.joint, out.joints, list);
  if (!joint) return;
  bool has_angle = false;
  list.children([&](List& part) {
    if (part.name == "n") joint->name = part.word();
    if (part.name == "vx") joint->degrees_per_s = part.number(), joint->has_speed = true;
    if (part.name != "ax") return;
    joint->degrees = part.number();
    has_angle = true;
  });
  if (joint->name.empty() || !has_angle) list.fail(SparkError::missing);
}

void read_force(List& list, SparkPercepts& out) noexcept {
  SparkForce* force = place_in(out.force, out.forces, list);
  if (!force) return;
  bool has_center = false, has_force = false;
  list.children([&](List& part) {
    if (part.name == "n") force->name = part.word();
    if (part.name == "c") {
      part.numbers(force->center_m);
      has_center = true;
    }
    if (part.name == "f") {
      part.numbers(force->force_n);
      has_force = true;
    }
  });
  if (force->name.empty() || !has_center || !has_force) list.fail(SparkError::missing);
}

/// "(pos (n NAME) (pos X Y Z))", "(quat (n NAME) (q W X Y Z))".
void read_place(List& list, SparkPercepts& out) noexcept {
  SparkPlace* place = place_in(out.place, out.places, list);
  if (!place) return;
  place->is_turn = list.name == "quat";
  bool found = false;
  list.children([&](List& part) {
    if (part.name == "n") place->name = part.word();
    if (part.name == "pos" && !place->is_turn) part.numbers(place->position_m), found = true;
    if (part.name == "q" && place->is_turn) part.numbers(place->q), found = true;
  });
  if (place->name.empty() || !found) list.fail(SparkError::missing);
}

void read_player(List& list, SparkPercepts& out) noexcept {
  std::string_view team;
  std::uint32_t number = 0;
  list.children([&](List& part) {
    if (part.name == "team") {
      team = part.word();
    } else if (part.name == "id") {
      number = part.count();
    } else {
      const std::string_view name = part.name;
      part.children([&](List& pol) {
        if (pol.name != "pol") return;
        if (SparkSeen* seen = place_in(out.seen, out.sightings, pol))
          *seen = {SparkSeen::Kind::player, name, team, number, polar_of(pol), {}};
      });
    }
  });
}

void read_see(List& list, SparkPercepts& out) noexcept {
  out.has_see = true;
  list.children([&](List& thing) {
    if (thing.name == "P") return read_player(thing, out);
    std::array<SparkPolar, 2> ends{};
    std::size_t found = 0;
    const std::string_view name = thing.name;
    thing.children([&](List& pol) {
      if (pol.name == "pol" && found < ends.size()) ends[found++] = polar_of(pol);
    });
    if (found == 0) {
      ++out.unknown;
      return;
    }
    const bool line = name == "L";
    if (line && found < 2) thing.fail(SparkError::missing);
    const auto kind = line ? SparkSeen::Kind::line : SparkSeen::Kind::landmark;
    if (SparkSeen* seen = place_in(out.seen, out.sightings, thing))
      *seen = {name == "B" ? SparkSeen::Kind::ball : kind, name, {}, 0, ends[0], line ? ends[1] : SparkPolar{}};
  });
}

/// "(hear [TEAM] TIME self|DEGREES TEXT)".
void read_heard(List& list, SparkPercepts& out) noexcept {
  SparkHeard* heard = place_in(out.heard, out.hears, list);
  if (!heard) return;
  // In early versions the server says no team; then there are three words.
  std::array<std::string_view, 4> words{};
  std::size_t count = 0;
  while (list.at_word() && count < words.size()) words[count++] = list.word();
  if (count < 3) return list.fail(SparkError::missing);
  const auto time = parse_number(words[count - 3]);
  if (!time) return list.fail(SparkError::number);
  heard->time_s = *time;
  if (count == 4) heard->team = words[0];
  const std::string_view from = words[count - 2];
  heard->text = words[count - 1];
  heard->self = from == "self";
  if (heard->self) return;
  const auto direction = parse_number(from);
  if (!direction) return list.fail(SparkError::number);
  heard->direction_deg = *direction;
}

void read_image(List& list, SparkPercepts& out) noexcept {
  SparkImage* image = place_in(out.image, out.images, list);
  if (!image) return;
  image->name = list.name;
  list.children([&](List& part) {
    if (part.name == "s") {
      image->width = part.count();
      image->height = part.count();
    }
    if (part.name == "d" && part.at_word()) image->base64 = part.word();
  });
}

}  // namespace

bool SparkFrames::push(char c) noexcept {
  if (complete_) {
    complete_ = false;
    size_ = 0;
    length_ = head_bytes_ = taken_ = 0;
  }
  if (head_bytes_ < kHead) {
    length_ = length_ << 8 | static_cast<unsigned char>(c);
    if (++head_bytes_ < kHead) return false;
    if (length_ > buffer_.size()) ++dropped_;
    return complete_ = length_ == 0;
  }
  ++taken_;
  if (length_ <= buffer_.size()) {
    buffer_[size_++] = c;
    return complete_ = taken_ == length_;
  }
  if (taken_ == length_) length_ = head_bytes_ = taken_ = 0;  // skipped
  return false;
}

const SparkJoint* SparkPercepts::find_joint(std::string_view name) const noexcept {
  const auto end = joint.begin() + static_cast<std::ptrdiff_t>(joints);
  const auto found = std::find_if(joint.begin(), end, [&](const SparkJoint& j) { return j.name == name; });
  return found == end ? nullptr : &*found;
}

SparkError parse_spark_percepts(std::string_view text, SparkPercepts& out) noexcept {
  out = {};
  Tokens tokens(text);
  return each_expression(tokens, [&](List& list) {
    if (list.name == "time") {
      list.children([&](List& part) {
        if (part.name == "now") out.now_s = part.number();
      });
    } else if (list.name == "GS") {
      read_game(list, out);
    } else if (list.name == "GYR") {
      out.has_gyro = read_vector(list, "rt", out.gyro_dps);
    } else if (list.name == "ACC") {
      out.has_acceleration = read_vector(list, "a", out.acceleration_mps2);
    } else if (list.name == "HJ") {
      read_joint(list, out);
    } else if (list.name == "FRP") {
      read_force(list, out);
    } else if (list.name == "See") {
      read_see(list, out);
    } else if (list.name == "pos" || list.name == "quat") {
      read_place(list, out);
    } else if (list.name == "hear") {
      read_heard(list, out);
    } else if (list.name.ends_with("IMG")) {
      read_image(list, out);
    } else {
      ++out.unknown;
    }
    return true;
  });
}

bool SparkEffectors::next(SparkEffector& out) noexcept {
  using Kind = SparkEffector::Kind;
  if (error_ != SparkError::none) return false;
  bool found = false;
  Tokens tokens(rest_);
  error_ = each_expression(tokens, [&](List& list) {
    if (found) return false;  // the next one; `rest_` is still in front of it
    found = true;
    out = {.name = list.name};
    if (list.name == "scene") {
      out.kind = Kind::scene;
      out.name = list.word();
      if (list.at_word()) out.type = list.count();
    } else if (list.name == "init") {
      out.kind = Kind::init;
      out.name = {};
      if (list.at_word()) {  // "(init T1 RED 2)"
        out.model = list.word();
        out.name = list.word();
        out.number = list.count();
      }
      list.children([&](List& part) {
        if (part.name == "unum") out.number = part.count();
        if (part.name == "teamname") out.name = part.word();
      });
      if (out.name.empty()) list.fail(SparkError::missing);
    } else if (list.name == "beam") {
      out.kind = Kind::beam;
      list.numbers(out.value);
    } else if (list.name == "say") {
      out.kind = Kind::say;
      out.name = list.word();
    } else if (list.name == "pass") {
      out.kind = Kind::pass;
    } else if (list.name == "syn") {
      out.kind = Kind::sync;
    } else if (list.at_word() && parse_number(list.word_ahead())) {
      out.kind = Kind::joint;
      out.value[0] = list.number();
      if (list.at_word()) {
        out.kind = Kind::motor;
        out.motor[0] = out.value[0];
        for (std::size_t i = 1; i < out.motor.size(); ++i) out.motor[i] = list.number();
      }
    }
    list.skip();
    rest_ = tokens.rest();
    return false;
  });
  return found && error_ == SparkError::none;
}

namespace {

void read_order(List& list, SparkOrder& out) noexcept {
  using Kind = SparkOrder::Kind;
  const auto side_and_number = [&](List& part) {
    if (part.name == "unum") out.number = part.count();
    if (part.name == "team") out.name = part.word();
  };
  if (list.name == "kickOff" || list.name == "playMode") {
    out.kind = list.name == "kickOff" ? Kind::kick_off : Kind::play_mode;
    out.name = list.word();
  } else if (list.name == "ball") {
    out.kind = Kind::ball;
    list.children([&](List& part) {
      if (part.name == "pos") part.numbers(out.position), out.has_position = true;
      if (part.name == "vel") part.numbers(out.velocity), out.has_velocity = true;
    });
    if (!out.has_position && !out.has_velocity) list.fail(SparkError::missing);
  } else if (list.name == "agent") {
    out.kind = Kind::player;
    out.name = {};
    list.children([&](List& part) {
      side_and_number(part);
      if (part.name != "pos" && part.name != "move") return;
      part.numbers(out.position);
      out.has_position = true;
      if (part.name == "move") out.degrees = part.number(), out.has_degrees = true;
    });
    if (out.name.empty() || out.number == 0) list.fail(SparkError::missing);
  } else if (list.name == "kill") {
    out.kind = Kind::kill_player;
    out.name = {};
    list.children(side_and_number);
    if (out.name.empty() || out.number == 0) list.fail(SparkError::missing);
  } else if (list.name == "time") {
    out.kind = Kind::time;
    out.value[0] = list.number();
  } else if (list.name == "score") {
    out.kind = Kind::score;
    list.children([&](List& part) {
      if (part.name == "left") out.value[0] = part.count();
      if (part.name == "right") out.value[1] = part.count();
    });
  } else if (list.name == "dropBall") {
    out.kind = Kind::drop_ball;
  } else if (list.name == "killsim") {
    out.kind = Kind::kill_server;
  } else if (list.name == "reqfullstate") {
    out.kind = Kind::request_state;
  }
}

}  // namespace

bool SparkOrders::next(SparkOrder& out) noexcept {
  if (error_ != SparkError::none) return false;
  bool found = false;
  Tokens tokens(rest_);
  error_ = each_expression(tokens, [&](List& list) {
    found = true;
    out = {.name = list.name};
    read_order(list, out);
    list.skip();
    rest_ = tokens.rest();
    return false;
  });
  return found && error_ == SparkError::none;
}

std::string_view to_string(SparkError error) noexcept {
  constexpr std::array<std::string_view, 7> kNames{"none",   "parenthesis", "depth",   "text",
                                                   "number", "missing",     "too_many"};
  return kNames[static_cast<std::size_t>(error)];
}

SparkWriter& SparkWriter::put(std::string_view text) noexcept {
  if (!fits_ || into_.size() < used_ || text.size() > into_.size() - used_) {
    fits_ = false;
    return *this;
  }
  std::copy(text.begin(), text.end(), into_.begin() + static_cast<std::ptrdiff_t>(used_));
  used_ += text.size();
  return *this;
}

SparkWriter& SparkWriter::open(std::string_view name) noexcept { return put("(").put(name); }
SparkWriter& SparkWriter::word(std::string_view word) noexcept { return put(" ").put(word); }
SparkWriter& SparkWriter::close() noexcept { return put(")"); }

SparkWriter& SparkWriter::number(double value, int decimals) noexcept {
  std::array<char, 336> text;
  const std::size_t size = write_fixed(value, decimals, text);
  return word(size == 0 ? std::string_view("0") : std::string_view(text.data(), size));
}

SparkWriter& SparkWriter::init(std::uint32_t number_, std::string_view team) noexcept {
  return open("init").put(" ").open("unum").number(number_, 0).close().open("teamname").word(team).close().close();
}

SparkWriter& SparkWriter::effector(std::string_view joint, double radps) noexcept {
  return open(joint).number(radps, kDecimals).close();
}

SparkWriter& SparkWriter::init(std::string_view model, std::string_view team, std::uint32_t number_) noexcept {
  return open("init").word(model).word(team).number(number_, 0).close();
}

SparkWriter& SparkWriter::motor(std::string_view name, const std::array<double, 5>& values) noexcept {
  open(name);
  for (const double value : values) number(value, kDecimals);
  return close();
}

SparkWriter& SparkWriter::beam(double x_m, double y_m, double degrees) noexcept {
  return open("beam").number(x_m).number(y_m).number(degrees).close();
}

SparkWriter& SparkWriter::polar(const SparkPolar& polar) noexcept {
  return put(" ").open("pol").number(polar.distance_m).number(polar.azimuth_deg).number(polar.elevation_deg).close();
}

SparkWriter& SparkWriter::percepts(const SparkPercepts& p) noexcept {
  const auto vector = [&](std::string_view name, const std::array<double, 3>& values) {
    put(" ").open(name);
    for (const double value : values) number(value);
    close();
  };
  open("time").put(" ").open("now").number(p.now_s).close().close();
  if (p.has_game) {
    open("GS");
    if (p.number > 0) put(" ").open("unum").number(p.number, 0).close();
    if (!p.side.empty()) put(" ").open("team").word(p.side).close();
    put(" ").open("sl").number(p.left_goals, 0).close().put(" ").open("sr").number(p.right_goals, 0).close();
    put(" ").open("t").number(p.game_s).close();
    if (!p.play_mode.empty()) put(" ").open("pm").word(p.play_mode).close();
    if (!p.left_team.empty()) put(" ").open("tl").word(p.left_team).close();
    if (!p.right_team.empty()) put(" ").open("tr").word(p.right_team).close();
    close();
  }
  for (const SparkPlace& place : std::span(p.place).first(p.places)) {
    open(place.is_turn ? "quat" : "pos").put(" ").open("n").word(place.name).close();
    put(" ").open(place.is_turn ? "q" : "pos");
    if (place.is_turn)
      for (const double value : place.q) number(value, 3);
    else
      for (const double value : place.position_m) number(value, 3);
    close().close();
  }
  if (p.has_gyro) {
    open("GYR").put(" ").open("n").word("torso").close();
    vector("rt", p.gyro_dps);
    close();
  }
  if (p.has_acceleration) {
    open("ACC").put(" ").open("n").word("torso").close();
    vector("a", p.acceleration_mps2);
    close();
  }
  for (const SparkJoint& joint : std::span(p.joint).first(p.joints)) {
    open("HJ").put(" ").open("n").word(joint.name).close().put(" ").open("ax").number(joint.degrees).close();
    if (joint.has_speed) put(" ").open("vx").number(joint.degrees_per_s).close();
    close();
  }
  for (const SparkForce& force : std::span(p.force).first(p.forces)) {
    open("FRP").put(" ").open("n").word(force.name).close();
    vector("c", force.center_m);
    vector("f", force.force_n);
    close();
  }
  if (p.has_see) {
    open("See");
    if (p.sightings == 0) put(" ");  // agents of others look for a blank behind each name
    for (std::size_t i = 0; i < p.sightings;) {
      const SparkSeen& first = p.seen[i];
      if (first.kind != SparkSeen::Kind::player) {
        put(" ").open(first.name).polar(first.at);
        if (first.kind == SparkSeen::Kind::line) polar(first.to);
        close();
        ++i;
        continue;
      }
      // The parts of one player follow each other.
      put(" ").open("P");
      if (!first.team.empty()) put(" ").open("team").word(first.team).close();
      if (first.number > 0) put(" ").open("id").number(first.number, 0).close();
      for (; i < p.sightings; ++i) {
        const SparkSeen& part = p.seen[i];
        if (part.kind != first.kind || part.team != first.team || part.number != first.number) break;
        put(" ").open(part.name).polar(part.at).close();
      }
      close();
    }
    close();
  }
  for (const SparkHeard& heard : std::span(p.heard).first(p.hears)) {
    open("hear");
    if (!heard.team.empty()) word(heard.team);
    number(heard.time_s);
    if (heard.self)
      word("self");
    else
      number(heard.direction_deg);
    word(heard.text).close();
  }
  for (const SparkImage& image : std::span(p.image).first(p.images)) {
    open(image.name).put(" ").open("s").number(image.width, 0).number(image.height, 0).close();
    put(" ").open("d").word(image.base64).close().close();
  }
  return *this;
}

std::span<const char> SparkWriter::frame() noexcept {
  if (!fits_ || into_.size() < kHead || used_ - kHead > 0xFFFFFFFFU) return {};
  const auto length = static_cast<std::uint32_t>(used_ - kHead);
  for (std::size_t i = 0; i < kHead; ++i) into_[i] = static_cast<char>(length >> (8 * (kHead - 1 - i)) & 0xFFU);
  return into_.first(used_);
}

}  // namespace sinew::wire
