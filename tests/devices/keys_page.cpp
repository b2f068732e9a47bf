#include "keys_page.hpp"

#include <algorithm>

namespace sinew::test {
namespace {

using drivers::KeyRow;
using drivers::KeyTable;

constexpr const char* kHead = R"(# Keys of devices, buses and joints

This page is written by the test `devices_keys_test` from the tables that the drivers read a robot file by: `SINEW_WRITE_DOCS=1 devices_keys_test`
writes it anew, and the test fails when it differs. [devices.md](../devices.md) says what the keys are for.

`sinew check` and `sinew run` refuse what is not in here, before anything is opened, as `file:line: key: value: what is allowed`. Every table has
`driver` beside these, a joint also `name`. What one key may be beside another (gains and the motor's ranges, time-outs and how often something
comes) is refused in the same way, and said with the key.
)";

std::string code(std::string_view text) { return "`" + std::string(text) + "`"; }

std::string cell(std::string_view text) {
  std::string out;
  for (const char c : text) out += c == '|' ? std::string("\\|") : std::string(1, c);
  return out;
}

std::string default_of(const KeyRow& row) {
  if (row.required) return "required";
  if (row.in_words) return cell(row.otherwise);
  return row.otherwise.empty() ? "none" : code(row.otherwise);
}

bool alike(const KeyRow& a, const KeyRow& b) {
  return a.type == b.type && a.unit == b.unit && a.allowed == b.allowed && a.doc == b.doc &&
         default_of(a) == default_of(b);
}

/// Neighbours that differ in nothing but their name share a line.
std::string rows_of(const std::vector<KeyRow>& rows) {
  std::string text = "\n| key | type | unit | default | allowed | meaning |\n|---|---|---|---|---|---|\n";
  for (std::size_t i = 0; i < rows.size();) {
    std::string names;
    std::size_t k = i;
    for (; k < rows.size() && alike(rows[i], rows[k]); ++k) names += (names.empty() ? "" : ", ") + code(rows[k].key);
    const KeyRow& r = rows[i];
    text += "| " + names + " | " + r.type + " | " + r.unit + " | " + default_of(r) + " | " + cell(r.allowed) + " | " +
            cell(r.doc) + " |\n";
    i = k;
  }
  return text;
}

std::string readers_of(const KeyTable& table) {
  std::string text;
  for (const std::string_view reader : table.readers) text += (text.empty() ? "" : ", ") + code(reader);
  return text;
}

bool same_keys(const KeyTable& a, const KeyTable& b) {
  return a.rows.size() == b.rows.size() &&
         std::equal(a.rows.begin(), a.rows.end(), b.rows.begin(),
                    [](const auto& x, const auto& y) { return x.key == y.key && alike(x, y); });
}

/// The tables of one header; those with the same keys are one.
std::string group(const std::vector<KeyTable>& tables, std::string_view header) {
  std::string text;
  std::vector<KeyTable> own;
  for (const KeyTable& t : tables)
    if (t.header == header) own.push_back(t);
  for (std::size_t i = 0; i < own.size();) {
    std::string names;
    std::size_t k = i;
    for (; k < own.size() && same_keys(own[i], own[k]); ++k) names += (names.empty() ? "" : ", ") + code(own[k].driver);
    text += "\n### " + names + "\n";
    text += own[i].rows.empty() ? (own[i].driver == "published" ? "\nNo keys.\n" : "\nNo keys but its joints'.\n")
                                : rows_of(own[i].rows);
    i = k;
  }
  return text;
}

}  // namespace

std::string keys_page(const std::vector<KeyTable>& tables) {
  std::string page = kHead;
  page +=
      "\n## Which driver for which module\n\nWho names a device by its parameter `device` (a module) or its own name "
      "(an "
      "actuator group) needs one of these drivers.\n\n| driver | measures | read by |\n|---|---|---|\n";
  for (const KeyTable& t : tables)
    if (!t.measures.empty())
      page += "| " + code(t.driver) + " | " + std::string(t.measures) + " | " + readers_of(t) + " |\n";
  page += "\n## `[device.NAME]`\n" + group(tables, "[device.NAME]");
  page += "\n## `[bus.NAME]`\n" + group(tables, "[bus.NAME]");
  for (const char* header :
       {"[[device.NAME.joint]]", "[[device.NAME.drive]]", "[[device.NAME.command]]", "[[device.NAME.message]]"})
    page += "\n## `" + std::string(header) + "`\n" + group(tables, header);
  return page;
}

}  // namespace sinew::test
