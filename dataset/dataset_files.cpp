#include "dataset/dataset_files.hpp"

#include <charconv>
#include <cmath>

namespace sinew::dataset {
namespace {

constexpr std::int64_t kMaxStampNs = std::int64_t{1} << 62;

template <class T>
bool whole_number(std::string_view text, T& out) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), out);
  return error == std::errc{} && end == text.data() + text.size();
}

std::string_view trimmed(std::string_view s) {
  while (!s.empty() && (s.front() == ' ' || s.front() == '\t')) s.remove_prefix(1);
  while (!s.empty() && (s.back() == ' ' || s.back() == '\t' || s.back() == '\r')) s.remove_suffix(1);
  return s;
}

/// Text of a file, shortened and without control characters, for a message to people.
std::string quoted(std::string_view s) {
  std::string out = "'";
  for (const char c : s.substr(0, 40)) out += c >= ' ' && c < 127 ? c : '?';
  return out + (s.size() > 40 ? "...'" : "'");
}

/// Reads the lines; stops at the first problem.
class Table {
 public:
  Table(std::string_view text, std::string_view file, std::size_t columns, std::string& why)
      : rest_(text), file_(file), columns_(columns), why_(why) {
    why_.clear();
  }

  /// The next line with values. False: the end, or a problem.
  bool next() {
    while (good() && !rest_.empty()) {
      const std::size_t end = rest_.find('\n');
      const std::string_view line = trimmed(rest_.substr(0, end));
      rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
      ++line_;
      if (!line.empty() && line.front() != '#') return split(line);
    }
    return false;
  }
  bool good() const { return why_.empty(); }

  /// Column 1, which must grow from line to line.
  std::int64_t stamp() {
    std::int64_t t = 0;
    if (!whole_number(fields_[0], t) || t < 0 || t >= kMaxStampNs)
      fail("column 1: " + quoted(fields_[0]) + " is not a time stamp in nanoseconds");
    else if (t <= last_)
      fail("column 1: stamp " + std::to_string(t) + " is not after the one before, " + std::to_string(last_));
    else
      last_ = t;
    return t;
  }
  double number(std::size_t column) {
    double v = 0;
    if (!whole_number(fields_[column], v) || !std::isfinite(v))
      fail("column " + std::to_string(column + 1) + ": " + quoted(fields_[column]) + " is not a finite number");
    return v;
  }
  msg::Vec3 vector(std::size_t column) {
    const double x = number(column), y = number(column + 1), z = number(column + 2);
    return {x, y, z};
  }
  std::string_view field(std::size_t column) const { return fields_[column]; }
  void fail(const std::string& what) {
    if (good()) why_ = std::string(file_) + ":" + std::to_string(line_) + ": " + what;
  }

 private:
  bool split(std::string_view line) {
    std::size_t found = 0;
    for (;; ++found) {
      const std::size_t comma = line.find(',');
      if (found < kMaxColumns) fields_[found] = trimmed(line.substr(0, comma));
      if (comma == std::string_view::npos) break;
      line.remove_prefix(comma + 1);
    }
    ++found;
    if (found < columns_)
      fail(std::to_string(found) + " columns; at least " + std::to_string(columns_) + " are needed");
    return good();
  }

  static constexpr std::size_t kMaxColumns = 17;
  std::string_view rest_, file_;
  std::size_t columns_;
  std::string& why_;
  std::string_view fields_[kMaxColumns];
  std::size_t line_ = 0;
  std::int64_t last_ = -1;
};

}  // namespace

bool parse_imu_csv(std::string_view text, std::string_view file, std::vector<msg::ImuSample>& out, std::string& why) {
  Table table(text, file, 7, why);
  while (table.next()) {
    const msg::ImuSample s{{table.stamp()}, table.vector(1), table.vector(4)};
    if (table.good()) out.push_back(s);
  }
  return table.good();
}

bool parse_image_list(std::string_view text, std::string_view file, std::vector<ImageEntry>& out, std::string& why) {
  Table table(text, file, 2, why);
  while (table.next()) {
    const ImageEntry e{table.stamp(), std::string(table.field(1))};
    const bool plain = !e.file.empty() && e.file.find_first_of(std::string_view("/\\\0", 3)) == std::string::npos &&
                       e.file != "." && e.file != "..";
    if (!plain) table.fail("column 2: " + quoted(table.field(1)) + " is not a file name without folders");
    if (table.good()) out.push_back(e);
  }
  return table.good();
}

bool parse_ground_truth_csv(std::string_view text, std::string_view file, std::vector<GroundTruthSample>& out,
                            std::string& why) {
  Table table(text, file, 17, why);
  while (table.next()) {
    GroundTruthSample s;
    s.stamp_ns = table.stamp();
    s.p_world_m = table.vector(1);
    s.q_world_base = {table.number(4), table.number(5), table.number(6), table.number(7)};
    s.v_world_mps = table.vector(8);
    s.gyro_bias_radps = table.vector(11);
    s.accel_bias_mps2 = table.vector(14);
    msg::Quat& q = s.q_world_base;
    const double n = std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
    if (!(n > 0.9 && n < 1.1)) table.fail("columns 5 to 8 are not a unit quaternion");
    if (!table.good()) break;
    q = {q.w / n, q.x / n, q.y / n, q.z / n};
    out.push_back(s);
  }
  return table.good();
}

bool stamp_of_image_name(std::string_view name, std::int64_t& stamp_ns) {
  if (!name.ends_with(".png")) return false;
  name.remove_suffix(4);
  std::int64_t t = 0;
  if (!whole_number(name, t) || t < 0 || t >= kMaxStampNs) return false;
  stamp_ns = t;
  return true;
}

}  // namespace sinew::dataset
