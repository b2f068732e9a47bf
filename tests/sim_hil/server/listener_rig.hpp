#pragma once
// A plant's listener on a Unix socket of the test's own.
#include <gtest/gtest.h>
#include <stdlib.h>

#include <filesystem>
#include <string>

#include "../board/rig.hpp"
#include "sim_hil/board/side_line.hpp"
#include "sim_hil/server/plant_listener.hpp"

namespace sinew::sim_hil {

/// An endpoint in a folder that goes away with it.
class Endpoint {
 public:
  Endpoint() {
    std::string name = (std::filesystem::temp_directory_path() / "sinew_door_XXXXXX").string();
    EXPECT_NE(mkdtemp(name.data()), nullptr);
    folder_ = name;
  }
  ~Endpoint() {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  std::string name() const { return "unix:" + folder_ + "/plant.sock"; }

 private:
  std::string folder_;
};

class DoorRig {
 public:
  explicit DoorRig(PlantDescription plant = small_plant(), const std::vector<std::string>& robots = {}) {
    auto listener = hal::listen_stream(endpoint_.name());
    EXPECT_TRUE(listener);
    plant_listener = std::move(*PlantListener::open(hal::system_os(), std::move(*listener), std::move(plant),
                                                    {"listener", 0, {}, 1 << 18}, robots));
  }
  std::string endpoint() const { return endpoint_.name(); }
  std::unique_ptr<hal::Stream> connect() const { return std::move(*hal::connect_stream(endpoint_.name(), kLong)); }
  std::unique_ptr<SideLine> side_line(std::string_view name = "parent") {
    auto line = SideLine::open(connect(), name, kLong, why);
    EXPECT_TRUE(line) << why;
    return line ? std::move(*line) : nullptr;
  }

 private:
  Endpoint endpoint_;

 public:
  std::unique_ptr<PlantListener> plant_listener;
  std::string why;
};

/// Says Hello as a runtime does; does not read the answer.
inline void say_hello(hal::Stream& stream, const Hello& hello = {}) {
  MessageWriter out(kMaxSmallBytes);
  EXPECT_TRUE(out.add(Type::hello, 0, Time{}, hello));
  EXPECT_TRUE(stream.write(out.pending()));
}

/// The type of the next message; of a Bye its words.
inline std::string next_word(hal::Stream& stream) {
  MessageReceiver in(Sender::plant);
  Message message;
  for (;;) {
    auto next = in.next(message);
    if (!next) return next.error().where;
    if (*next) break;
    auto n = stream.read(in.space());
    if (!n) return hal::to_string(n.error().code);
    in.filled(*n);
  }
  if (message.header.type == Type::bye) return decode_text(message.payload);
  return std::string(to_string(message.header.type));
}

}  // namespace sinew::sim_hil
