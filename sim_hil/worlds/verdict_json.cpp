#include "sim_hil/worlds/verdict_json.hpp"

#include <vector>

#include "sim_hil/worlds/json_object.hpp"

namespace sinew::plant {
namespace {

std::vector<std::string> measures_json(const std::vector<Measure>& all) {
  std::vector<std::string> measures;
  for (const Measure& m : all) {
    JsonObject j;
    j.text("key", m.key);
    j.text("label", m.label);
    j.text("unit", m.unit);
    j.number("value", m.value);
    if (m.limit) j.number(m.at_least ? "at_least" : "at_most", *m.limit);
    measures.push_back(j.done());
  }
  return measures;
}

}  // namespace

std::string verdict_json(const Verdict& verdict) {
  JsonObject j;
  j.text("outcome", verdict.outcome);
  j.boolean("good", verdict.good);
  j.boolean("begun", verdict.begun);
  j.list("measures", measures_json(verdict.measures));
  j.list("conditions", measures_json(verdict.conditions));
  return j.done();
}

}  // namespace sinew::plant
