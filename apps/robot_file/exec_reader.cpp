#include "apps/robot_file/exec_reader.hpp"

#include <cmath>

namespace sinew::app {
namespace {

using namespace std::chrono_literals;
using rt::Duration;

constexpr double kExecUs = 1e3;
constexpr Duration kLongestExec = 3600s;

/// False: not a number of microseconds from 0.001 to 3.6e9.
bool read_us(const toml::node& node, Duration& time) {
  const double us = node.value<double>().value_or(0.0);
  if (!(us >= 0.001 && us <= 3.6e9)) return false;
  time = Duration{std::llround(us * kExecUs)};
  return true;
}

void read_exec_quantiles(TomlReader& r, rt::ExecModel& exec) {
  const toml::node* node = r.take("exec_quantiles_us");
  if (!node) return;
  const toml::array* pairs = node->as_array();
  bool good = pairs && !pairs->empty();
  for (std::size_t i = 0; good && i < pairs->size(); ++i) {
    const toml::array* pair = (*pairs)[i].as_array();
    rt::ExecModel::Quantile quantile{};
    good = pair && pair->size() == 2 && (*pair)[0].is_number() && read_us((*pair)[1], quantile.exec);
    if (!good) break;
    quantile.share = (*pair)[0].value<double>().value_or(0.0);
    exec.quantiles.push_back(quantile);
  }
  exec.kind = rt::ExecModel::Kind::quantiles;  // the graph's check tests that they rise
  if (!good) r.problem(*node, "exec_quantiles_us", "an array of pairs [share, us], us from 0.001 to 3.6e9");
}

}  // namespace

void read_exec(TomlReader& r, rt::ExecModel& exec) {
  using Kind = rt::ExecModel::Kind;
  if (r.read_time("exec_us", exec.constant, kExecUs, 1ns, kLongestExec)) exec.kind = Kind::constant;
  if (const toml::node* node = r.take("exec_trace_us")) {
    const toml::array* array = node->as_array();
    bool good = array && !array->empty();
    for (std::size_t i = 0; good && i < array->size(); ++i) {
      Duration time{};
      good = read_us((*array)[i], time);
      if (good) exec.trace.push_back(time);
    }
    if (good) {
      exec.kind = Kind::trace;
    } else {
      r.problem(*node, "exec_trace_us", "an array of numbers from 0.001 to 3.6e9");
    }
  }
  read_exec_quantiles(r, exec);
  if (r.read("exec_measured_factor", exec.factor, 0.01, 1000.0)) exec.kind = Kind::measured;
  const char* first = nullptr;
  int models = 0;
  for (const char* key : {"exec_us", "exec_trace_us", "exec_quantiles_us", "exec_measured_factor"}) {
    if (!r.has(key)) continue;
    if (!first) first = key;
    ++models;
  }
  if (models > 1)
    r.problem(*r.raw().get(first), first,
              "only one of exec_us, exec_trace_us, exec_quantiles_us, exec_measured_factor");
}

}  // namespace sinew::app
