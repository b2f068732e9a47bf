#pragma once
#include <memory>
#include <span>
#include <string>

#include "sim_hil/usarsim/robot.hpp"

namespace sinew::usarsim {

/// One connection of the text server, without its socket: bytes of a client in, bytes for it out. A client has at most
/// one robot, which is in the place until the session ends. It drives on as it was last told while its client is
/// silent, as the original does; a client that is gone takes it away. Thread:  owner.   Errors: none; what a client
/// says wrongly is counted, and answered where the original does.
class Session {
 public:
  static constexpr std::size_t kMostWaiting = std::size_t{256} * 1024;  // bytes that a client has not read yet

  /// `address`: the client's, for the choice of pictures; `number`: among all connections, for its errors' seed.
  Session(Game& game, std::string address, std::uint64_t number);
  ~Session();
  Session(const Session&) = delete;

  void receive(std::span<const std::byte> bytes);
  /// Says what is due at the place's time.
  void tick();
  /// Waits to be sent; drop_sent() takes off what was.
  std::string_view waiting() const { return std::string_view(out_).substr(sent_); }
  void drop_sent(std::size_t bytes);

  const Robot* robot() const { return robot_.get(); }

 private:
  void obey(const wire::UsarLine& line);
  void init(const wire::UsarLine& line);
  hal::Result<std::size_t> enter(const RobotClass& kind, const wire::UsarLine& line);
  void drive(const wire::UsarLine& line);
  void drive_rotors(const wire::UsarLine& line);
  void drive_wheels(const wire::UsarLine& line);
  void drive_steered(const wire::UsarLine& line);
  void drive_joint(const wire::UsarLine& line);
  void drive_joints(const wire::UsarLine& line);
  std::string move_joint(std::string_view name, std::string_view text, std::optional<bool> by_rate);
  void turn_camera(const wire::UsarLine& line);
  void move_links(const wire::UsarLine& line);
  void set(const wire::UsarLine& line);
  void set_camera(const wire::UsarLine& line);
  void set_viewports(const wire::UsarLine& line);
  void zoom(double fov_rad);
  void answer(const wire::UsarLine& line, bool configuration);
  void tell_start_poses();
  void control(const wire::UsarLine& line);
  void create(const wire::UsarLine& line);
  void move(const wire::UsarLine& line, bool relative);
  void kill_all(const wire::UsarLine& line);
  void tell_things(const wire::UsarLine& line);

  void refuse(const std::string& what, const std::string& why);
  void refuse_drive(const char* type, const std::string& why);
  void unusable() { ++game_.counts().unusable; }
  void say(std::string_view line);
  plant::Vehicle& vehicle() { return robot_->vehicle(); }

  Game& game_;
  std::string address_;
  std::uint64_t number_;
  wire::UsarLines lines_;
  wire::UsarLine line_;
  std::uint64_t dropped_before_ = 0;
  std::unique_ptr<Robot> robot_;
  std::string out_;
  std::size_t sent_ = 0;
};

}  // namespace sinew::usarsim
