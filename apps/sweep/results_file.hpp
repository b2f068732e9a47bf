#pragma once
// Results of a sweep in one file, a JSON object a line: first what the sweep is, then a line for each case as it ends.
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "apps/command/json.hpp"

namespace sinew::sweep {

using app::Json;

inline constexpr std::uint64_t kMostCases = 100'000'000;  // of a sweep: one bit each is held

/// What makes a sweep this one and no other. Two files belong to the same sweep when their Identity is equal.
struct Identity {
  std::uint64_t cases = 0;
  Json what{};  // all that decides the cases and their results: robot file with its hash, program, options
};

/// Which part of a sweep's cases: those whose number leaves `index` when divided by `count`.
struct Shard {
  std::uint64_t index = 0, count = 1;  // "2/5" is {1, 5}
  bool has(std::uint64_t number) const { return number % count == index; }
};

/// "2/5". Nothing: it is no such text.
std::optional<Shard> parse_shard(std::string_view text);

/// What differs between two sweeps, in words: "seeds: 1..10 there, 1..20 here"; empty: they are the same one.
std::string what_differs(const Identity& there, const Identity& here);

/// Appends results. Each line is written with one call, so that kill -9 loses at most a part of the last line, which
/// the next opening removes.
/// Thread:  owner. Errors: a reason in words.
class ResultsFile {
 public:
  /// Makes the file, or goes on with one. Errors (null, with `why`): it belongs to another sweep or shard (what differs
  /// is named), it is no such file, another process writes it, the disk.
  static std::unique_ptr<ResultsFile> open(const std::string& path, const Identity& identity, const Shard& shard,
                                           std::string& why);
  virtual ~ResultsFile() = default;

  virtual bool has(std::uint64_t number) const = 0;
  virtual std::uint64_t count() const = 0;  // of cases that are in the file
  /// `result`: one object; "case" is put first. The bytes depend on the case and its result alone.
  virtual bool append(std::uint64_t number, const Json& result, std::string& why) = 0;
  /// Sorts the lines by case and replaces the file at once; without the cases from `end` on.
  virtual bool finish(std::uint64_t end, std::string& why) = 0;
};

struct ResultLine {
  std::uint64_t number;   // of the case
  const Json& result;     // the object of the line
  std::string_view text;  // the line, without its end
  std::uint64_t begin;    // where it is in the file
};
/// Reads a file of any sweep, in the order of its lines; keeps none of them. `each`: false stops. Errors: false, with
/// `why`; a last line without its end is no error.
using EachResult = std::function<bool(const ResultLine& line)>;
bool read_results(const std::string& path, Identity& identity, Shard& shard, const EachResult& each, std::string& why);

/// Writes one sorted file of the shards of a sweep: the file of the undivided sweep byte for byte, once all cases are
/// there. A file that is at `out` already must be of the same sweep, and keeps its cases. Cases that several files have
/// must be equal. `missing`: the first of the cases that no file has, at most 20,
/// and `missing_count` of them all. Errors: false, with `why`: files of different sweeps, unequal results of a case
/// (both files named).
struct Merged {
  Identity identity{};
  std::vector<std::uint64_t> missing{};
  std::uint64_t missing_count = 0;
};
bool merge_results(const std::vector<std::string>& paths, const std::string& out, Merged& merged, std::string& why);

}  // namespace sinew::sweep
