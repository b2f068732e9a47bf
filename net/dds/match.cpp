#include "net/dds/match.hpp"

#include <fnmatch.h>

#include <algorithm>

namespace sinew::net {
namespace {

bool has_wildcard(const std::string& name) { return name.find_first_of("*?[") != std::string::npos; }

bool partition_names_match(const std::string& a, const std::string& b) {
  if (has_wildcard(a) && has_wildcard(b)) return false;  // DDS: patterns do not match patterns
  if (has_wildcard(a)) return fnmatch(a.c_str(), b.c_str(), 0) == 0;
  if (has_wildcard(b)) return fnmatch(b.c_str(), a.c_str(), 0) == 0;
  return a == b;
}

std::string listed_partitions(const std::vector<std::string>& names) {
  if (names.empty()) return "none";
  std::string out;
  for (const std::string& name : names) out += (out.empty() ? "'" : ", '") + name + "'";
  return out;
}

std::string milliseconds_text(Duration d) {
  return d.count() == 0 ? "none" : std::to_string(d / std::chrono::milliseconds(1)) + " ms";
}

/// What a reader asks for and a writer does not offer.
std::string offered_less(const DdsQos& writer, const DdsQos& reader, const std::string& writer_is,
                         const std::string& reader_is) {
  if (reader.reliable && !writer.reliable)
    return "reliability: " + reader_is + " asks for reliable, " + writer_is + " offers best effort";
  if (reader.transient_local && !writer.transient_local)
    return "durability: " + reader_is + " asks for transient local, " + writer_is + " offers volatile";
  const bool slower =
      reader.deadline.count() != 0 && (writer.deadline.count() == 0 || writer.deadline > reader.deadline);
  if (slower)
    return "deadline: " + reader_is + " asks for " + milliseconds_text(reader.deadline) + ", " + writer_is +
           " offers " + milliseconds_text(writer.deadline);
  return {};
}

}  // namespace

bool partitions_match(const std::vector<std::string>& a, const std::vector<std::string>& b) {
  static const std::vector<std::string> kNameless{""};
  for (const std::string& one : a.empty() ? kNameless : a)
    for (const std::string& other : b.empty() ? kNameless : b)
      if (partition_names_match(one, other)) return true;
  return false;
}

bool is_counterpart(const OwnEndpoint& own, const RemoteEndpoint& remote) {
  return own.writes != remote.writes && own.spec.topic == remote.topic;
}

std::string why_no_match(const OwnEndpoint& own, const RemoteEndpoint& remote) {
  if (own.spec.type != remote.type) return "type: ours is " + own.spec.type + ", its is " + remote.type;
  const std::string us = own.writes ? "our writer" : "our reader", it = remote.writes ? "its writer" : "its reader";
  std::string why =
      own.writes ? offered_less(own.spec.qos, remote.qos, us, it) : offered_less(remote.qos, own.spec.qos, it, us);
  if (!why.empty()) return why;
  if (!partitions_match(own.spec.qos.partitions, remote.qos.partitions))
    return "partition: ours " + listed_partitions(own.spec.qos.partitions) + ", its " +
           listed_partitions(remote.qos.partitions);
  if (!remote.xcdr1) return "data representation: it has XCDR2 only, we have XCDR1";
  return {};
}

}  // namespace sinew::net
