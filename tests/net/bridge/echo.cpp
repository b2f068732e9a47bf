// echo types DISTRO: all types as OMG IDL, as one file.
// echo msg DISTRO: all definitions with their nested types, as JSON by name.
// echo samples DISTRO DOMAIN: writes a sample of every type on rt/there/N, waits for it on rt/back/N, and compares
// bytes; first reliable, then best effort.
#include <poll.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <set>

#include "hal/platform.hpp"
#include "math/random.hpp"
#include "net/dds/participant.hpp"
#include "net/ros2/definitions.hpp"
#include "net/ros2/value.hpp"

using namespace sinew;
using namespace std::chrono_literals;
using Bytes = std::vector<std::uint8_t>;

namespace {

/// In the order of their definitions, without our own (names of fields that are words of IDL have no place in a peer's
/// C++).
std::vector<const ros2::Type*> types_of(ros2::Distro distro) {
  std::vector<const ros2::Type*> all;
  for (const ros2::Type& type : ros2::known_types(distro).all()) all.push_back(&type);
  return all;
}

void fill(const ros2::Type& type, ros2::Value& value, math::Random& random, std::vector<Bytes>& store);
void fill_one(const ros2::Field& f, ros2::Value& v, math::Random& random, std::vector<Bytes>& store) {
  if (f.kind == ros2::Kind::nested) return fill(*f.nested, v, random, store);
  if (f.kind == ros2::Kind::text)
    v.text = std::string(random.below(5), static_cast<char>('a' + random.below(26)));
  else if (f.kind == ros2::Kind::f32 || f.kind == ros2::Kind::f64)
    v.set((static_cast<double>(random.below(2000)) - 1000) * 0.125);
  else if (f.kind == ros2::Kind::boolean)
    v.set_integer(random.below(2));
  else
    v.set_integer(random.below(120));
}
void fill(const ros2::Type& type, ros2::Value& value, math::Random& random, std::vector<Bytes>& store) {
  ros2::Message::make_default(type, value);
  for (std::size_t i = 0; i < type.fields.size(); ++i) {
    const ros2::Field& f = type.fields[i];
    ros2::Value& v = value.items[i];
    if (f.shape == ros2::Shape::one) {
      fill_one(f, v, random, store);
      continue;
    }
    std::size_t count = f.shape == ros2::Shape::fixed ? f.count : 1 + random.below(3);
    if (f.shape == ros2::Shape::sequence && f.count != 0) count = std::min<std::size_t>(count, f.count);
    if (f.kind == ros2::Kind::u8 || f.kind == ros2::Kind::i8) {
      store.emplace_back(count, static_cast<std::uint8_t>(random.below(256)));
      v.bytes = store.back();
      continue;
    }
    v.items.resize(count);
    for (ros2::Value& item : v.items) fill_one(f, item, random, store);
  }
}

std::string cpp_name(std::string name) {
  for (auto at = name.find('/'); at != name.npos; at = name.find('/')) name.replace(at, 1, "::");
  return name;
}

/// One IDL with each type once.
void print_idl(ros2::Distro distro) {
  std::set<std::string> seen;
  for (const ros2::Type* type : types_of(distro)) {
    std::string idl = ros2::idl_of(*type);
    for (std::size_t at = 0; at < idl.size();) {
      const std::size_t end = idl.find("}; };\n", at) + 6;
      const std::string part = idl.substr(at, end - at);
      if (seen.insert(part).second) std::fputs(part.c_str(), stdout);
      at = end;
    }
  }
}

void print_list(ros2::Distro distro) {
  for (const ros2::Type* type : types_of(distro))
    std::printf("%s %s\n", type->name.c_str(), cpp_name(type->name).c_str());
}

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) out += c == '\n' ? "\\n" : c == '"' ? "\\\"" : c == '\\' ? "\\\\" : std::string(1, c);
  return out + "\"";
}

void print_definitions(ros2::Distro distro) {
  std::printf("{");
  const char* comma = "";
  for (const ros2::Type* type : types_of(distro)) {
    math::Random random(3);
    std::vector<Bytes> store;
    store.reserve(100000);
    ros2::Message message(*type);
    fill(*type, message.root(), random, store);
    Bytes bytes;
    ros2::encode(*type, message.root(), bytes);
    std::string hex;
    for (const std::uint8_t b : bytes) {
      char two[3];
      std::snprintf(two, sizeof two, "%02x", b);
      hex += two;
    }
    std::printf("%s\n%s: {\"definition\": %s, \"sample\": \"%s\"}", comma, quoted(type->name).c_str(),
                quoted(ros2::with_nested(*type)).c_str(), hex.c_str());
    comma = ",";
  }
  std::printf("}\n");
}

bool wait_until(net::Participant& participant, hal::Duration longest, const std::function<bool()>& done) {
  const hal::Time end = hal::system_os().now() + longest;
  while (!done()) {
    if (hal::system_os().now() > end) return false;
    pollfd wait{participant.wake_fd(), POLLIN, 0};
    ::poll(&wait, 1, 50);
    participant.begin_look();
  }
  return true;
}

int samples(ros2::Distro distro, std::uint32_t domain, bool reliable) {
  net::ParticipantOptions options;
  options.domain = domain, options.interfaces = {"127.0.0.1"}, options.multicast = false, options.peers = {"127.0.0.1"};
  std::string why;
  const auto participant = net::Participant::open(options, why);
  if (!participant) return std::fprintf(stderr, "%s\n", why.c_str()), 1;
  struct Way {
    const ros2::Type* type;
    std::unique_ptr<net::DdsWriter> there;
    std::unique_ptr<net::DdsReader> back;
  };
  std::vector<Way> ways;
  for (const ros2::Type* type : types_of(distro)) {
    const std::string n = std::to_string(ways.size());
    net::EndpointSpec spec;
    spec.type = ros2::dds_type_name(type->name);
    spec.qos.reliable = reliable, spec.qos.depth = 10;
    spec.topic = (reliable ? "rt/there/" : "rt/there_fast/") + n;
    auto there = (*participant)->write(spec, why);
    spec.topic = (reliable ? "rt/back/" : "rt/back_fast/") + n;
    auto back = (*participant)->read(spec, why);
    if (!there || !back) return std::fprintf(stderr, "%s: %s\n", spec.topic.c_str(), why.c_str()), 1;
    ways.push_back({type, std::move(*there), std::move(*back)});
  }
  int failed = 0;
  math::Random random(reliable ? 1 : 2);
  for (Way& way : ways) {
    if (!wait_until(**participant, 20s, [&] { return way.there->matched() > 0 && way.back->matched() > 0; })) {
      std::printf("%s: the peer does not match\n", way.type->name.c_str());
      ++failed;
      continue;
    }
    for (int round = 0; round < 3; ++round) {
      std::vector<Bytes> store;
      store.reserve(100000);
      ros2::Message message(*way.type), again(*way.type);
      fill(*way.type, message.root(), random, store);
      Bytes bytes;
      ros2::encode(*way.type, message.root(), bytes);
      net::DdsSample sample;
      bool came = false;
      for (int attempt = 0; attempt < (reliable ? 1 : 20) && !came; ++attempt) {
        if (!way.there->write(bytes)) break;
        came = wait_until(**participant, reliable ? 5s : 200ms, [&] { return way.back->take(sample); });
      }
      Bytes back;
      if (came && ros2::decode(*way.type, sample.cdr, again.root())) ros2::encode(*way.type, again.root(), back);
      if (back == bytes) continue;
      std::printf("%s: %s\n", way.type->name.c_str(), came ? "other values came back" : "nothing came back");
      ++failed;
      break;
    }
  }
  std::printf("%zu types %s, %d failed\n", ways.size(), reliable ? "reliable" : "best effort", failed);
  return failed == 0 ? 0 : 1;
}

int parameter(const std::string& node, const std::string& name, std::uint32_t domain) {
  net::ParticipantOptions options;
  options.domain = domain, options.interfaces = {"127.0.0.1"}, options.multicast = false, options.peers = {"127.0.0.1"};
  std::string why;
  const auto participant = net::Participant::open(options, why);
  if (!participant) return std::fprintf(stderr, "%s\n", why.c_str()), 1;
  net::EndpointSpec spec;
  spec.qos.reliable = true, spec.qos.depth = 10;
  spec.topic = "rq" + node + "/get_parametersRequest", spec.type = "rcl_interfaces::srv::dds_::GetParameters_Request_";
  const auto ask = (*participant)->write(spec, why);
  spec.topic = "rr" + node + "/get_parametersReply", spec.type = "rcl_interfaces::srv::dds_::GetParameters_Response_";
  const auto answer = (*participant)->read(spec, why);
  if (!ask || !answer) return std::fprintf(stderr, "%s\n", why.c_str()), 1;
  if (!wait_until(**participant, 20s, [&] { return (*ask)->matched() > 0 && (*answer)->matched() > 0; }))
    return std::fprintf(stderr, "no such service\n"), 1;
  const auto& types = ros2::known_types(ros2::Distro::humble);
  ros2::Message request(*types.find("rcl_interfaces/srv/GetParameters_Request")),
      reply(*types.find("rcl_interfaces/srv/GetParameters_Response"));
  request.find("names")->items.resize(1);
  request.find("names[0]")->text = name;
  Bytes bytes;
  ros2::encode(request.type(), request.root(), bytes);
  const Bytes head{1, 2, 3, 4, 5, 6, 7, 8, 42, 0, 0, 0, 0, 0, 0, 0};  // the client, and the number of its request
  bytes.insert(bytes.begin() + 4, head.begin(), head.end());
  net::DdsSample sample;
  if (!(*ask)->write(bytes) || !wait_until(**participant, 10s, [&] { return (*answer)->take(sample); }))
    return std::fprintf(stderr, "no answer\n"), 1;
  if (sample.cdr.size() < 20 || !std::equal(head.begin(), head.end(), sample.cdr.begin() + 4))
    return std::fprintf(stderr, "the answer to somebody else\n"), 1;
  sample.cdr.erase(sample.cdr.begin() + 4, sample.cdr.begin() + 20);
  if (!ros2::decode(reply.type(), sample.cdr, reply.root())) return std::fprintf(stderr, "no reply\n"), 1;
  std::printf("%.17g\n", reply.find("values[0].double_value")->number());
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) return 2;
  const ros2::Distro distro = std::strcmp(argv[2], "jazzy") == 0 ? ros2::Distro::jazzy : ros2::Distro::humble;
  const std::string what = argv[1];
  if (what == "types") return print_idl(distro), 0;
  if (what == "list") return print_list(distro), 0;
  if (what == "msg") return print_definitions(distro), 0;
  if (what == "parameter" && argc == 5)
    return parameter(argv[2], argv[3], static_cast<std::uint32_t>(std::atoi(argv[4])));
  if (what != "samples" || argc < 4) return 2;
  const auto domain = static_cast<std::uint32_t>(std::atoi(argv[3]));
  return samples(distro, domain, true) + samples(distro, domain, false);
}
