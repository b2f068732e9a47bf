// The C interface: no exception leaves it.
#include "client/sinew_client.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>
#include <new>
#include <nlohmann/json.hpp>

#include "client/robot.hpp"
#include "tap/frames.hpp"
#include "tap/names.hpp"

struct sinew_robots {
  std::vector<sinew::tap::Running> all;
};

struct sinew_robot {
  explicit sinew_robot(std::string_view name) : robot(name) {}
  sinew::client::Robot robot;
};

namespace sinew::client {
namespace {

thread_local std::array<char, 1024> g_last_error{};

int fail(int code, std::string_view why) noexcept {
  const std::size_t n = std::min(why.size(), g_last_error.size() - 1);
  std::memcpy(g_last_error.data(), why.data(), n);
  g_last_error[n] = '\0';
  return code;
}

/// Runs what may throw.
template <class Body>
int guarded(Body&& body) noexcept {
  try {
    body();
    return SINEW_OK;
  } catch (const Failure& f) {
    return fail(f.code, f.why);
  } catch (const std::bad_alloc&) {
    return fail(SINEW_OUT_OF_MEMORY, "no memory");
  } catch (const nlohmann::json::exception&) {
    return fail(SINEW_BAD_DATA, "the robot's reply lacks something that its protocol demands");
  } catch (const std::exception& e) {
    return fail(SINEW_IO, e.what());
  }
}

void need(bool there, const char* what) {
  if (!there) throw Failure{SINEW_BAD_ARGUMENT, std::string(what) + " is NULL"};
}

hal::Duration duration_of(std::int64_t timeout_ns) {
  return hal::Duration{timeout_ns < 0 ? SINEW_DEFAULT_TIMEOUT_NS : timeout_ns};
}

sinew_field to_c(const Field& f) {
  return {f.name.c_str(), f.unit.c_str(), f.doc.c_str(),       f.names.c_str(), static_cast<std::uint32_t>(f.kind),
          f.offset,       f.count,        f.is_array ? 1U : 0U};
}

static_assert(static_cast<int>(msg::Kind::i8) == SINEW_I8 && static_cast<int>(msg::Kind::u64) == SINEW_U64 &&
              static_cast<int>(msg::Kind::f32) == SINEW_F32 && static_cast<int>(msg::Kind::f64) == SINEW_F64);
static_assert(static_cast<int>(hal::Errc::not_found) + 1 == SINEW_NOT_FOUND &&
              static_cast<int>(hal::Errc::io) + 1 == SINEW_IO);

}  // namespace
}  // namespace sinew::client

using sinew::client::Failure;
using sinew::client::guarded;
using sinew::client::need;

int sinew_client_abi(void) { return SINEW_CLIENT_ABI; }

const char* sinew_code_name(int code) {
  if (code == SINEW_OK) return "ok";
  if (code == SINEW_OVERWRITTEN) return "overwritten";
  if (code < 0 || code > SINEW_OVERWRITTEN) return "unknown";
  return sinew::tap::code_name(static_cast<sinew::hal::Errc>(code - 1));
}

const char* sinew_last_error(void) { return sinew::client::g_last_error.data(); }

int sinew_robots_list(sinew_robots** list) {
  return guarded([&] {
    need(list, "list");
    std::string why;
    auto all = sinew::tap::running(why);
    if (!all) throw sinew::client::failure(all.error(), why);
    *list = new sinew_robots{std::move(*all)};
  });
}

size_t sinew_robots_count(const sinew_robots* list) { return list ? list->all.size() : 0; }

const char* sinew_robots_name(const sinew_robots* list, size_t index) {
  return index < sinew_robots_count(list) ? list->all[index].robot.c_str() : nullptr;
}

int sinew_robots_pid(const sinew_robots* list, size_t index) {
  return index < sinew_robots_count(list) ? list->all[index].pid : 0;
}

void sinew_robots_free(sinew_robots* list) { delete list; }

int sinew_attach(const char* name, sinew_robot** robot) {
  return guarded([&] {
    need(robot, "robot");
    *robot = new sinew_robot(name ? name : "");
  });
}

void sinew_detach(sinew_robot* robot) { delete robot; }

const char* sinew_name(const sinew_robot* robot) { return robot ? robot->robot.client().robot().c_str() : ""; }

int sinew_pid(const sinew_robot* robot) { return robot ? robot->robot.client().pid() : 0; }

int sinew_now(sinew_robot* robot, int64_t* now_ns, int64_t* offset_ns) {
  return guarded([&] {
    need(robot, "robot");
    need(now_ns, "now_ns");
    robot->robot.now(*now_ns, offset_ns);
  });
}

size_t sinew_topic_count(const sinew_robot* robot) { return robot ? robot->robot.topics().size() : 0; }

int sinew_topic_at(const sinew_robot* robot, uint32_t topic, sinew_topic* about) {
  return guarded([&] {
    need(robot, "robot");
    need(about, "about");
    robot->robot.check_topic(topic);
    const auto& t = robot->robot.topics()[topic];
    const auto& layout = robot->robot.layout(topic);
    *about = {t.name.c_str(),
              t.type.c_str(),
              layout.message_bytes,
              layout.bulk_bytes,
              static_cast<uint32_t>(t.fields.size()),
              layout.keep,
              t.external ? 1 : 0,
              t.wakes_outsiders ? 1 : 0,
              t.rate_hz};
  });
}

int sinew_topic_find(const sinew_robot* robot, const char* name, uint32_t* topic) {
  return guarded([&] {
    need(robot, "robot");
    need(name, "name");
    need(topic, "topic");
    *topic = robot->robot.find_topic(name);
  });
}

int sinew_field_at(const sinew_robot* robot, uint32_t topic, uint32_t index, sinew_field* about) {
  return guarded([&] {
    need(robot, "robot");
    need(about, "about");
    robot->robot.check_topic(topic);
    const auto& fields = robot->robot.topics()[topic].fields;
    if (index >= fields.size())
      throw Failure{SINEW_BAD_ARGUMENT, "field " + std::to_string(index) + " of " + std::to_string(fields.size())};
    *about = sinew::client::to_c(fields[index]);
  });
}

int sinew_field_find(const sinew_robot* robot, uint32_t topic, const char* name, sinew_field* about) {
  return guarded([&] {
    need(robot, "robot");
    need(name, "name");
    need(about, "about");
    robot->robot.check_topic(topic);
    const auto& t = robot->robot.topics()[topic];
    const auto at = std::find_if(t.fields.begin(), t.fields.end(), [&](const auto& f) { return f.name == name; });
    if (at == t.fields.end()) throw Failure{SINEW_NOT_FOUND, t.type + " has no field " + name};
    *about = sinew::client::to_c(*at);
  });
}

int sinew_latest(const sinew_robot* robot, uint32_t topic, sinew_message* message) {
  return guarded([&] {
    need(robot, "robot");
    need(message, "message");
    robot->robot.check_topic(topic);
    *message = robot->robot.newest(topic);
  });
}

int sinew_wait(sinew_robot* robot, uint32_t topic, int64_t timeout_ns, sinew_message* message) {
  return guarded([&] {
    need(robot, "robot");
    need(message, "message");
    robot->robot.check_topic(topic);
    *message = robot->robot.wait(topic, sinew::client::duration_of(timeout_ns));
  });
}

int sinew_next(sinew_robot* robot, uint32_t topic, int64_t timeout_ns, sinew_message* message) {
  return guarded([&] {
    need(robot, "robot");
    need(message, "message");
    robot->robot.check_topic(topic);
    *message = robot->robot.next(topic, sinew::client::duration_of(timeout_ns));
  });
}

int sinew_wake_at_once(sinew_robot* robot, uint32_t topic, int on) {
  return guarded([&] {
    need(robot, "robot");
    robot->robot.check_topic(topic);
    robot->robot.wake_at_once(topic, on != 0);
  });
}

int sinew_still_valid(const sinew_robot* robot, const sinew_message* message) {
  if (!robot || !message || message->topic >= robot->robot.topics().size()) return 0;
  return robot->robot.holds(*message) ? 1 : 0;
}

int sinew_copy(const sinew_robot* robot, const sinew_message* message, void* into, size_t bytes) {
  return guarded([&] {
    need(robot, "robot");
    need(message, "message");
    need(into, "into");
    robot->robot.check_topic(message->topic);
    robot->robot.copy(*message, {static_cast<std::byte*>(into), bytes});
  });
}

int sinew_param_get(sinew_robot* robot, const char* module, const char* param, sinew_value* value) {
  return guarded([&] {
    need(robot, "robot");
    need(module, "module");
    need(param, "param");
    need(value, "value");
    robot->robot.get_param(module, param, *value);
  });
}

int sinew_param_set(sinew_robot* robot, const char* module, const char* param, const sinew_value* value) {
  return guarded([&] {
    need(robot, "robot");
    need(module, "module");
    need(param, "param");
    need(value, "value");
    robot->robot.set_param(module, param, *value);
  });
}

int sinew_request(sinew_robot* robot, const char* name, const char* arguments, const char** reply) {
  return guarded([&] {
    need(robot, "robot");
    need(name, "name");
    need(reply, "reply");
    *reply = nullptr;
    *reply = robot->robot.ask(name, arguments ? arguments : "{}").c_str();
    robot->robot.check_reply();
  });
}

int sinew_loan(sinew_robot* robot, uint32_t topic, void** message, void** bulk, size_t* bulk_room) {
  return guarded([&] {
    need(robot, "robot");
    need(message, "message");
    robot->robot.check_topic(topic);
    const auto loan = robot->robot.loan(topic);
    *message = loan.message.data();
    if (bulk) *bulk = loan.bulk.empty() ? nullptr : loan.bulk.data();
    if (bulk_room) *bulk_room = loan.bulk.size();
  });
}

int sinew_send(sinew_robot* robot, size_t bulk_bytes, int64_t stamp_ns, unsigned flags) {
  return guarded([&] {
    need(robot, "robot");
    robot->robot.send(bulk_bytes, stamp_ns, (flags & SINEW_NO_WAIT) == 0);
  });
}

int sinew_publish(sinew_robot* robot, uint32_t topic, const void* message, size_t message_bytes, const void* bulk,
                  size_t bulk_bytes, int64_t stamp_ns, unsigned flags) {
  return guarded([&] {
    need(robot, "robot");
    need(message, "message");
    if (bulk_bytes != 0) need(bulk, "bulk");
    robot->robot.check_topic(topic);
    const auto loan = robot->robot.loan(topic);
    if (message_bytes != loan.message.size())
      throw Failure{SINEW_BAD_ARGUMENT, std::to_string(message_bytes) + " bytes: a message of " +
                                            robot->robot.topics()[topic].name + " has " +
                                            std::to_string(loan.message.size())};
    if (bulk_bytes > loan.bulk.size())
      throw Failure{SINEW_BAD_ARGUMENT,
                    std::to_string(bulk_bytes) + " bytes of pixels: room for " + std::to_string(loan.bulk.size())};
    std::memcpy(loan.message.data(), message, message_bytes);
    if (bulk_bytes != 0) std::memcpy(loan.bulk.data(), bulk, bulk_bytes);
    robot->robot.send(bulk_bytes, stamp_ns, (flags & SINEW_NO_WAIT) == 0);
  });
}
