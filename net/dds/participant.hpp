#pragma once
// DDS without generated types: bytes of CDR with a topic's and a type's name. Nothing of Cyclone DDS is in this header.
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "hal/clock.hpp"
#include "hal/result.hpp"

namespace sinew::net {

using hal::Duration;
using Guid = std::array<std::uint8_t, 16>;  // of an endpoint or a participant, unique in the network
std::string to_text(const Guid& guid);      // "0110d1b2.4f7c9a11.00000001.00000103"

/// Paths of files in PEM; the two documents are XML, signed with S/MIME (docs/net.md). Empty: without DDS Security.
struct DdsSecurity {
  std::string identity_ca, certificate, private_key;
  std::string permissions_ca, governance, permissions;
  bool used() const { return !identity_ca.empty() || !certificate.empty() || !private_key.empty(); }
};

struct ParticipantOptions {
  std::uint32_t domain = 0;              // 0..kMostDomain
  std::vector<std::string> interfaces;   // names or IPv4 addresses; empty: the one that Cyclone finds best
  bool multicast = true;                 // false: only `peers` are looked for
  std::vector<std::string> peers;        // addresses, "10.0.0.2" or "10.0.0.2:7410"
  std::uint32_t most_on_a_machine = 32;  // participants that may be found by unicast, of each machine; to kMostIndexed
  DdsSecurity security{};
  std::string user_data;  // what others see with it: ROS 2 writes "enclave=/;" there
  std::string extra;      // elements in Cyclone's own words, put below <Domain>

  static constexpr std::uint32_t kMostDomain = 232, kMostIndexed = 119;
};

/// What a writer offers, or a reader asks for. A reader gets nothing from a writer that offers less.
struct DdsQos {
  bool reliable = false;
  bool transient_local = false;         // what was written before a reader came, it gets, too
  std::uint32_t depth = 1;              // how many samples are kept; 0: all
  Duration deadline{};                  // the longest time between two samples; 0: none
  Duration lifespan{};                  // a writer's: older samples are not delivered; 0: none
  std::vector<std::string> partitions;  // empty: the one without a name
  Duration patience{};                  // a reliable writer's that keeps all: how long write() may wait for room
};

struct EndpointSpec {
  std::string topic, type;  // DDS's names: of ROS 2's /odom "rt/odom" and "nav_msgs::msg::dds_::Odometry_"
  DdsQos qos{};
  std::string user_data;  // ROS 2 from Iron on: "typehash=RIHS01_...;"
};

/// An endpoint somewhere in the domain, also one that does not match any of ours.
struct RemoteEndpoint {
  Guid guid{}, participant{};
  bool writes = false;
  std::string topic, type;
  DdsQos qos{};
  bool xcdr1 = true;  // false: it takes or writes only XCDR2, which we do not
  std::string user_data;
};

struct RemoteParticipant {
  Guid guid{};
  std::string user_data;
};

/// One received sample.
struct DdsSample {
  std::vector<std::uint8_t> cdr;     // as it came, with CDR's head: 00 01: little endian, 00 00: big endian
  std::int64_t written_wall_ns = 0;  // by the writer's own clock, since 1970
  Guid writer{};                     // all 0: it had ended before it was looked at
};

/// Writes one topic.
/// Thread:  any.   RT: no (takes locks, allocates).
class DdsWriter {
 public:
  virtual ~DdsWriter() = default;
  /// `cdr`: with head, 00 01 00 00 and XCDR1 in little endian.
  /// Errors:  bad_argument: shorter than a head; busy: no room within `patience`; io.
  virtual hal::Status write(std::span<const std::uint8_t> cdr) = 0;
  virtual std::uint32_t matched() const = 0;  // readers that get it now
  virtual Guid guid() const = 0;
};

/// Reads one topic; at most qos.depth samples wait.
/// Thread:  any.   RT: no.
class DdsReader {
 public:
  virtual ~DdsReader() = default;
  /// The oldest that waits; false: none. `out` keeps its memory.
  virtual bool take(DdsSample& out) = 0;
  virtual std::uint32_t matched() const = 0;  // writers that it hears now
  virtual std::uint64_t lost() const = 0;     // samples that were written for it, and never came or found no room
  virtual Guid guid() const = 0;
};

/// One member of a DDS domain. It has a network of its own, so that two in one process are like two in two processes.
/// It does not follow a changed address of this machine, not even when it is made again: that needs a new process.
/// A process with a participant should not lock its memory: each takes some 250 MB then.
/// Its own writers' samples do not come back to its own readers.
/// Thread:  any.   RT: no.
/// Owner:   writers and readers end before their participant.
class Participant {
 public:
  /// Errors:  bad_argument: options, or Cyclone refuses its configuration; not_found: no network, or no such interface;
  ///          busy: as many participants of the domain as may be on this machine; denied: a file of `security`;
  ///          io. `why` has it in words.
  static hal::Result<std::unique_ptr<Participant>> open(const ParticipantOptions& options, std::string& why);
  virtual ~Participant() = default;

  /// Errors:  bad_argument: names or QoS; denied: by DDS Security; io.
  virtual hal::Result<std::unique_ptr<DdsWriter>> write(const EndpointSpec& spec, std::string& why) = 0;
  virtual hal::Result<std::unique_ptr<DdsReader>> read(const EndpointSpec& spec, std::string& why) = 0;

  /// Readable when a reader has something to take, or an endpoint or a participant came or went; for poll().
  virtual int wake_fd() const = 0;
  /// To be called before the readers are asked: what comes later makes wake_fd() readable again.
  virtual void begin_look() = 0;

  virtual Guid guid() const = 0;
  /// All that are heard in the domain, without our own; in the order of their GUIDs.
  virtual std::vector<RemoteEndpoint> endpoints() = 0;
  virtual std::vector<RemoteParticipant> participants() = 0;
};

/// What Cyclone had to say since the last call, a line each, of all participants of this process; the newest 64.
/// Thread:  any.
std::vector<std::string> take_dds_log();

}  // namespace sinew::net
