#include "apps/search/case_result.hpp"

#include <fmt/format.h>

#include <sstream>

#include "apps/search/outcome_text.hpp"

namespace sinew::search {
namespace {

CaseResult violated(const char* invariant, std::string what) {
  CaseResult r;
  r.outcome.violation = Violation{invariant, {}, std::move(what)};
  return r;
}

/// The last line that is not empty.
std::string last_line(const std::string& text) {
  std::istringstream in(text);
  std::string line, last;
  while (std::getline(in, line))
    if (!line.empty()) last = line;
  return last;
}

std::optional<Outcome> last_outcome(const std::string& text) {
  std::istringstream in(text);
  std::string line;
  std::optional<Outcome> outcome;
  while (std::getline(in, line))
    if (auto o = parse_outcome(line)) outcome = std::move(o);
  return outcome;
}

}  // namespace

CaseResult case_result(const sweep::JobResult& job, hal::Duration patience) {
  if (!job.not_started.empty()) return {{}, job.not_started};
  if (job.hung)
    return violated("end", fmt::format("the process hangs: no outcome within {:.0f} s", msg::seconds(patience)));
  std::string last = last_line(job.errors);
  if (last.empty()) last = last_line(job.output);
  if (job.code >= 128) return violated("crash", fmt::format("the process died of signal {}: {}", job.code - 128, last));
  auto outcome = last_outcome(job.output);
  if (job.code > 1 || !outcome) return {{}, fmt::format("exit code {}: {}", job.code, last)};
  return {std::move(*outcome), {}};
}

}  // namespace sinew::search
