#pragma once
// What a robot file says about a policy, and what comes of it together with the network and the types of the topics.
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "policy/onnx/network.hpp"
#include "rt/failsafe.hpp"
#include "rt/graph_spec.hpp"

namespace sinew::policy {

inline constexpr std::size_t kMostEntries = 256;
inline constexpr std::uint32_t kMostHistory = 64, kMostDelay = 64;

/// x * scale + offset, then limited to low..high.
struct Shaping {
  double scale = 1, offset = 0;
  std::optional<double> low{}, high{};
};

/// `[[module.NAME.observe]]`: some neighbours in an input of the network. Just one of topic, output and value counts.
struct Observed {
  int line = 0;
  std::string key{};    // "module.walk.observe.0"
  std::string input{};  // of the network; empty: the only one
  std::string topic{};
  std::vector<std::string> fields{};  // of the topic's messages
  std::string output{};               // of the network: as it was in the step before
  std::optional<double> value{};      // always the same
  std::vector<Shaping> shaping{};     // one for all numbers, or one for each
  std::uint32_t history = 1;          // this step and so many - 1 before
  std::uint32_t delay = 0;            // steps
};

/// `[[module.NAME.command]]`: neighbours of an output of the network as fields of a message.
struct Commanded {
  int line = 0;
  std::string key{};
  std::string to{};                   // the module's output: "motor" of the topic "walk.motor"
  std::vector<std::string> fields{};  // of its message
  std::string output{};               // of the network; empty: the only one
  std::uint32_t index = 0;            // of the first number there
  std::optional<double> value{};      // in place of the network's numbers
  std::vector<Shaping> shaping{};
  std::uint32_t delay = 0;
};

/// The tables of one module.
struct PolicyOptions {
  std::string name{};  // of the module
  int line = 0, file_line = 0;
  std::vector<Observed> observed{};
  std::vector<Commanded> commanded{};
  std::map<std::string, std::string> recurrent{};  // input of the network: the output that it gets of the step before
  int recurrent_line = 0;
  std::uint32_t history = 1;  // the whole observation of so many steps
  bool newest_first = false;  // in every history
};

/// The network's file, read by whoever has files.
struct PolicyFile {
  std::string path{};     // as the robot file writes it
  std::string place{};    // where it was read; empty: not from a file
  std::string bytes{};    // empty: it could not be read
  std::string problem{};  // why
};
/// As recordings have it: 16 digits.
std::string hash_of(const PolicyFile& file);
/// Of the copy of a module's network in a recording.
std::string attachment_name(std::string_view module);

/// The input of the module for a topic: "in_imu_raw".
std::string topic_port(std::string_view topic);
/// Each topic once, in the order of the file.
std::vector<std::string> observed_topics(const PolicyOptions& options);
/// Each output of the module once, likewise.
std::vector<std::string> commanded_ports(const PolicyOptions& options);

/// One number that is observed.
struct Source {
  enum class Kind : std::uint8_t { field, output, value } kind = Kind::value;
  std::uint32_t topic = 0;   // field: of observed_topics()
  rt::NumberField field{};   // field
  std::uint32_t output = 0;  // output: index in Plan::watched
  Shaping shaping{};
  std::uint32_t past = 0, depth = 0;  // where its earlier values lie, and how many
};
/// Which number goes where.
struct Feed {
  std::uint32_t input = 0, index = 0;  // of the network
  std::uint32_t source = 0, age = 0;   // steps ago
};
/// One number that is commanded.
struct Command {
  std::uint32_t port = 0;  // of commanded_ports()
  rt::NumberField field{};
  std::uint32_t output = 0, index = 0;
  std::optional<double> value{};
  Shaping shaping{};
  std::uint32_t past = 0, delay = 0;
};
struct Recurrence {
  std::uint32_t input = 0, output = 0, first = 0, size = 0;
};
struct Watched {
  std::uint32_t output = 0, index = 0;
};

struct Plan {
  std::vector<Source> sources{};
  std::vector<Feed> feeds{};
  std::vector<Command> commands{};
  std::vector<Recurrence> recurrences{};
  std::vector<Watched> watched{};               // outputs that are observed a step later
  std::size_t past = 0, sent = 0, carried = 0;  // numbers to remember
  std::uint32_t most_delay = 0;
  std::vector<std::uint32_t> plain_inputs{}, plain_outputs{};  // of the network, without the recurrent ones
};

/// Types of the topics and of the module's outputs, in the order of observed_topics() and commanded_ports().
struct PlanTypes {
  std::vector<const msg::TypeInfo*> topics{}, ports{};
};

/// Everything that does not fit is one problem each, with its line of the robot file: fields that a message does not
/// have, names and sizes that the network does not have, an observation of another length than its input. RT: no.
Plan make_plan(const PolicyOptions& options, const PlanTypes& types, const onnx::Network& network,
               std::vector<rt::Problem>& problems);

/// The network of the file; null, with problems at the line of its name.
std::unique_ptr<onnx::Network> load_network(const PolicyOptions& options, const PolicyFile& file,
                                            std::vector<rt::Problem>& problems);

/// A line for people: "walk: 12 numbers from 2 topics, 4 commands; walk.onnx (hash): 5 operations, 46592
/// multiplications".
std::string describe(const PolicyOptions& options, const PolicyFile& file, const onnx::Network& network);

}  // namespace sinew::policy
