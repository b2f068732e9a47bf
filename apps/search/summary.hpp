#pragma once
#include "apps/search/case_flight.hpp"

namespace sinew::search {

/// The figures of many flights.
class Summary {
 public:
  /// `excused`: its ages are left out.
  void add(const Case& c, const Excuses& excused, const Outcome& outcome);
  std::string text() const;
  std::string json() const;

 private:
  std::uint64_t runs_ = 0, with_faults_ = 0, faults_ = 0, overruns_ = 0, steps_ = 0;
  double virtual_s_ = 0;
  std::map<std::string, std::uint64_t> endings_;
  std::map<std::string, std::vector<double>> figures_;  // name and unit -> one value a flight
};

}  // namespace sinew::search
