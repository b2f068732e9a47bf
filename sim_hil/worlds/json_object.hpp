#pragma once
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

namespace sinew::plant {

/// Builds one JSON object. Texts are ours or printable ASCII of the peer.
class JsonObject {
 public:
  void number(const char* key, double value) {
    char text[64];
    std::snprintf(text, sizeof text, "%.9g", value);
    raw(key, std::isfinite(value) ? text : "null");
  }
  void integer(const char* key, std::uint64_t value) { raw(key, std::to_string(value)); }
  void boolean(const char* key, bool value) { raw(key, value ? "true" : "false"); }
  void text(const char* key, const std::string& value) {
    std::string quoted = "\"";
    for (const char c : value) {
      if (c == '"' || c == '\\') quoted += '\\';
      quoted += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
    }
    raw(key, quoted + "\"");
  }
  void list(const char* key, const std::vector<std::string>& objects) {
    std::string all;
    for (const std::string& o : objects) all += (all.empty() ? "" : ",") + o;
    raw(key, "[" + all + "]");
  }
  void object(const char* key, const std::string& json) { raw(key, json); }
  std::string done() const { return out_ + "}"; }

 private:
  void raw(const char* key, const std::string& value) {
    out_ += out_.size() > 1 ? "," : "";
    out_ += '"';
    out_ += key;
    out_ += "\":";
    out_ += value;
  }
  std::string out_ = "{";
};

}  // namespace sinew::plant
