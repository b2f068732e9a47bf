#pragma once
// Why an endpoint that is there does not hear us, or we do not hear it.
#include <string>

#include "net/dds/participant.hpp"

namespace sinew::net {

/// An endpoint of ours.
struct OwnEndpoint {
  EndpointSpec spec{};
  bool writes = false;
};

/// What keeps the two apart, in words, of all that does the first by DDS's own order; empty: nothing, they match.
/// Only for a writer and a reader of one topic (is_counterpart()).
/// Source:  DDS 1.4, section 2.2.3 (RxO), and XTypes 1.3, section 7.6.3.
std::string why_no_match(const OwnEndpoint& own, const RemoteEndpoint& remote);

/// One of them writes and the other reads, and their topics have one name.
bool is_counterpart(const OwnEndpoint& own, const RemoteEndpoint& remote);

/// Names of partitions match, also with * and ?; none is the one without a name.
bool partitions_match(const std::vector<std::string>& a, const std::vector<std::string>& b);

}  // namespace sinew::net
