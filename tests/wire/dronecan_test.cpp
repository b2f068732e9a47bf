#include "wire/dronecan.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <string_view>

#include "wire/crc_ccitt.hpp"
#include "wire/dronecan_bits.hpp"
#include "wire/dronecan_types.hpp"
#include "wire/random_can_frame.hpp"

namespace sinew::wire::dronecan_test {
namespace {

using namespace std::chrono_literals;
using Bytes = std::vector<std::uint8_t>;
using Heard = DronecanAssembler::Heard;

Bytes data_of(const msg::CanFrame& frame) { return {frame.bytes().begin(), frame.bytes().end()}; }

template <class T>
Bytes payload_of(const T& message) {
  Bytes out(kDronecanMaxPayload);
  out.resize(encode(message, out));
  return out;
}

std::vector<msg::CanFrame> frames_of(const DronecanId& id, std::uint64_t signature, std::uint8_t transfer,
                                     const Bytes& payload) {
  DronecanSplitter splitter(id, signature, transfer, payload);
  std::vector<msg::CanFrame> out;
  for (msg::CanFrame frame; splitter.next(frame);) out.push_back(frame);
  return out;
}

DronecanId message(const DronecanWanted& type, std::uint8_t source, std::uint8_t priority = 8) {
  DronecanId id;
  id.priority = priority, id.type = type.type, id.source = source;
  return id;
}

// Identifiers and bytes: made by pydronecan, node 42, priority 8.
TEST(Dronecan, RawCommandIsTheReferenceStacks) {
  DronecanEscRawCommand command;
  command.count = 4;
  command.command = {0, 8191, -8192, 4096};
  const auto frames =
      frames_of(message(kDronecanEscRawCommand, 42), kDronecanEscRawCommand.signature, 5, payload_of(command));
  ASSERT_EQ(frames.size(), 1u);
  EXPECT_EQ(frames[0].id, 0x0804062Au);
  EXPECT_TRUE(frames[0].extended());
  EXPECT_EQ(data_of(frames[0]), (Bytes{0x00, 0x03, 0xFD, 0xF0, 0x08, 0x00, 0x10, 0xC5}));
}

TEST(Dronecan, ArrayCommandOfOneAndOfThreeIsTheReferenceStacks) {
  DronecanActuatorCommand command;
  command.count = 1;
  command.command[0] = {1, 1, 0.5};
  auto frames =
      frames_of(message(kDronecanActuatorCommand, 42), kDronecanActuatorCommand.signature, 0, payload_of(command));
  ASSERT_EQ(frames.size(), 1u);
  EXPECT_EQ(frames[0].id, 0x0803F22Au);
  EXPECT_EQ(data_of(frames[0]), (Bytes{0x01, 0x01, 0x00, 0x38, 0xC0}));

  command.count = 3;
  for (std::uint8_t i = 0; i < 3; ++i) command.command[i] = {i, 1, 0.5};
  frames = frames_of(message(kDronecanActuatorCommand, 42), kDronecanActuatorCommand.signature, 0, payload_of(command));
  ASSERT_EQ(frames.size(), 2u);
  EXPECT_EQ(data_of(frames[0]), (Bytes{0xBA, 0xB5, 0x00, 0x01, 0x00, 0x38, 0x01, 0x80})) << "with the transfer's CRC";
  EXPECT_EQ(data_of(frames[1]), (Bytes{0x01, 0x00, 0x38, 0x02, 0x01, 0x00, 0x38, 0x60}));
}

// ---- signatures ----

std::uint64_t crc64(std::span<const std::uint8_t> bytes, std::uint64_t crc) {
  for (const std::uint8_t byte : bytes) {
    crc ^= static_cast<std::uint64_t>(byte) << 56;
    for (int i = 0; i < 8; ++i) crc = (crc >> 63) != 0 ? crc << 1 ^ 0x42F0E1EBA9EA3693 : crc << 1;
  }
  return crc;
}

/// A data type's signature by its normalized definition and those of the types in it. Source: DroneCAN specification,
/// "Data structure description language", signature (CRC-64-WE).
std::uint64_t signature(std::string_view definition, std::initializer_list<std::uint64_t> parts = {}) {
  std::uint64_t crc =
      crc64({reinterpret_cast<const std::uint8_t*>(definition.data()), definition.size()}, ~std::uint64_t{0});
  for (const std::uint64_t part : parts) {
    const std::uint64_t so_far = ~crc;
    std::uint8_t bytes[16];
    for (int i = 0; i < 8; ++i) {
      bytes[i] = static_cast<std::uint8_t>(part >> (8 * i));
      bytes[8 + i] = static_cast<std::uint8_t>(so_far >> (8 * i));
    }
    crc = crc64(bytes, crc);
  }
  return ~crc;
}

TEST(Dronecan, SignaturesFollowFromTheDefinitions) {
  EXPECT_EQ(signature("uavcan.equipment.esc.RawCommand\nsaturated int14[<=20] cmd"), kDronecanEscRawCommand.signature);
  EXPECT_EQ(signature("uavcan.equipment.safety.ArmingStatus\nsaturated uint8 status"), kDronecanArmingStatus.signature);
  EXPECT_EQ(signature("uavcan.equipment.esc.Status\nsaturated uint32 error_count\nsaturated float16 voltage\n"
                      "saturated float16 current\nsaturated float16 temperature\nsaturated int18 rpm\n"
                      "saturated uint7 power_rating_pct\nsaturated uint5 esc_index"),
            kDronecanEscStatus.signature);
  const std::uint64_t one = signature(
      "uavcan.equipment.actuator.Command\nsaturated uint8 actuator_id\n"
      "saturated uint8 command_type\nsaturated float16 command_value");
  EXPECT_EQ(
      signature("uavcan.equipment.actuator.ArrayCommand\nuavcan.equipment.actuator.Command[<=15] commands", {one}),
      kDronecanActuatorCommand.signature);
  EXPECT_EQ(signature("uavcan.equipment.actuator.Status\nsaturated uint8 actuator_id\nsaturated float16 position\n"
                      "saturated float16 force\nsaturated float16 speed\nvoid1\nsaturated uint7 power_rating_pct"),
            kDronecanActuatorStatus.signature);
  const std::uint64_t status = signature(
      "uavcan.protocol.NodeStatus\nsaturated uint32 uptime_sec\nsaturated uint2 health\n"
      "saturated uint3 mode\nsaturated uint3 sub_mode\n"
      "saturated uint16 vendor_specific_status_code");
  EXPECT_EQ(status, kDronecanNodeStatus.signature);
  const std::uint64_t software = signature(
      "uavcan.protocol.SoftwareVersion\nsaturated uint8 major\nsaturated uint8 minor\n"
      "saturated uint8 optional_field_flags\nsaturated uint32 vcs_commit\n"
      "saturated uint64 image_crc");
  const std::uint64_t hardware = signature(
      "uavcan.protocol.HardwareVersion\nsaturated uint8 major\nsaturated uint8 minor\n"
      "saturated uint8[16] unique_id\n"
      "saturated uint8[<=255] certificate_of_authenticity");
  EXPECT_EQ(signature("uavcan.protocol.GetNodeInfo\n---\nuavcan.protocol.NodeStatus status\n"
                      "uavcan.protocol.SoftwareVersion software_version\n"
                      "uavcan.protocol.HardwareVersion hardware_version\nsaturated uint8[<=80] name",
                      {status, software, hardware}),
            kDronecanGetNodeInfo.signature);
  EXPECT_EQ(signature("uavcan.protocol.dynamic_node_id.Allocation\nsaturated uint7 node_id\n"
                      "saturated bool first_part_of_unique_id\nsaturated uint8[<=16] unique_id"),
            kDronecanAllocation.signature);
}

// ---- identifiers ----

TEST(Dronecan, IdentifiersComeBackAsTheyWere) {
  std::mt19937 random(10);
  for (int i = 0; i < 5000; ++i) {
    const std::uint32_t bits = static_cast<std::uint32_t>(random()) & 0x1FFFFFFF;
    DronecanId id;
    if (!dronecan_parse_id(bits, id)) {
      EXPECT_TRUE((bits & 0x80) != 0 && ((bits & 0x7F) == 0 || (bits & 0x7F00) == 0));
      continue;
    }
    ASSERT_EQ(dronecan_can_id(id), bits);
  }
}

TEST(Dronecan, ServicesNameBothSidesAndTheirDirection) {
  DronecanId id;
  id.priority = 30, id.service = true, id.request = true, id.type = 1, id.source = 10, id.destination = 42;
  EXPECT_EQ(dronecan_can_id(id), 0x1E01AA8Au);
}

// ---- transfers ----

const DronecanWanted kAll[] = {kDronecanNodeStatus,    kDronecanGetNodeInfo,     kDronecanAllocation,
                               kDronecanEscRawCommand, kDronecanActuatorCommand, kDronecanActuatorStatus,
                               kDronecanEscStatus};

/// Gives frames to an assembler, at times that it chooses.
struct Receiver {
  explicit Receiver(std::size_t places = 4) : assembler(kAll, places) {}
  Heard push(const msg::CanFrame& frame, Time at = {}) { return assembler.push(frame, at, 42, transfer); }
  Heard push(const std::vector<msg::CanFrame>& frames) {
    Heard last = Heard::foreign;
    for (const auto& frame : frames) last = push(frame);
    return last;
  }
  Bytes payload() const { return {transfer.payload.begin(), transfer.payload.end()}; }
  DronecanAssembler assembler;
  DronecanTransfer transfer;
};

Bytes bytes_of(std::size_t size) {
  Bytes out(size);
  for (std::size_t i = 0; i < size; ++i) out[i] = static_cast<std::uint8_t>(i * 7 + 1);
  return out;
}

TEST(Dronecan, TransfersOfEverySizeArePutTogether) {
  Receiver receiver;
  for (std::size_t size = 0; size <= kDronecanMaxPayload; ++size) {
    const Bytes payload = bytes_of(size);
    const auto frames = frames_of(message(kDronecanEscStatus, 9), kDronecanEscStatus.signature,
                                  static_cast<std::uint8_t>(size), payload);
    ASSERT_EQ(frames.size(), size <= 7 ? 1 : (size + 2 + 6) / 7);
    for (std::size_t i = 0; i + 1 < frames.size(); ++i) ASSERT_EQ(receiver.push(frames[i]), Heard::partial);
    ASSERT_EQ(receiver.push(frames.back()), Heard::complete) << size;
    ASSERT_EQ(receiver.payload(), payload);
    ASSERT_EQ(receiver.transfer.transfer_id, size % 32);
    ASSERT_EQ(receiver.transfer.id, message(kDronecanEscStatus, 9));
  }
  EXPECT_EQ(receiver.assembler.stats().transfers, kDronecanMaxPayload + 1);
}

TEST(Dronecan, TransfersOfManySendersMayBeMixed) {
  Receiver receiver(4);
  std::vector<std::vector<msg::CanFrame>> senders;
  for (std::uint8_t node = 1; node <= 4; ++node)
    senders.push_back(frames_of(message(kDronecanActuatorStatus, node), kDronecanActuatorStatus.signature, node,
                                bytes_of(20 + node)));
  int complete = 0;
  for (std::size_t i = 0; i < 4; ++i)
    for (auto& frames : senders)
      if (i < frames.size() && receiver.push(frames[i]) == Heard::complete) {
        ++complete;
        EXPECT_EQ(receiver.payload(), bytes_of(20u + receiver.transfer.id.source));
      }
  EXPECT_EQ(complete, 4);
}

TEST(Dronecan, LostFramesCostTheirTransferAndNoOther) {
  const auto frames = frames_of(message(kDronecanEscStatus, 9), kDronecanEscStatus.signature, 3, bytes_of(40));
  for (std::size_t lost = 0; lost < frames.size(); ++lost) {
    Receiver receiver;
    for (std::size_t i = 0; i < frames.size(); ++i)
      if (i != lost) {
        EXPECT_NE(receiver.push(frames[i]), Heard::complete) << lost;
      }
    EXPECT_EQ(receiver.push(frames), Heard::complete) << "the next one is whole again, " << lost;
  }
}

TEST(Dronecan, FrameThatCameTwiceIsLeftOut) {
  const auto frames = frames_of(message(kDronecanEscStatus, 9), kDronecanEscStatus.signature, 3, bytes_of(40));
  Receiver receiver;
  EXPECT_EQ(receiver.push(frames[0]), Heard::partial);
  EXPECT_EQ(receiver.push(frames[1]), Heard::partial);
  EXPECT_EQ(receiver.push(frames[1]), Heard::broken);
  for (std::size_t i = 2; i + 1 < frames.size(); ++i) EXPECT_EQ(receiver.push(frames[i]), Heard::partial);
  EXPECT_EQ(receiver.push(frames.back()), Heard::complete);
  EXPECT_EQ(receiver.payload(), bytes_of(40));
  EXPECT_EQ(receiver.assembler.stats().stray, 1u);
}

TEST(Dronecan, AnyChangedBitOfALongTransferIsNoticed) {
  const auto frames = frames_of(message(kDronecanEscStatus, 9), kDronecanEscStatus.signature, 3, bytes_of(14));
  for (std::size_t f = 0; f < frames.size(); ++f)
    for (std::size_t bit = 0; bit < 8 * (frames[f].size - 1); ++bit) {
      auto changed = frames;
      changed[f].data[bit / 8] = static_cast<std::uint8_t>(changed[f].data[bit / 8] ^ (1u << bit % 8));
      Receiver receiver;
      ASSERT_EQ(receiver.push(changed), Heard::broken);
      ASSERT_EQ(receiver.assembler.stats().crc_errors, 1u);
    }
}

TEST(Dronecan, TransferOfAnotherTypeWithTheSameBytesFailsItsCrc) {
  auto frames = frames_of(message(kDronecanEscStatus, 9), 0x1234, 3, bytes_of(14));
  Receiver receiver;
  EXPECT_EQ(receiver.push(frames), Heard::broken);
  EXPECT_EQ(receiver.assembler.stats().crc_errors, 1u);
}

TEST(Dronecan, PlacesAreBoundedAndFreedAfterTwoSeconds) {
  Receiver receiver(2);
  const auto first_of = [](std::uint8_t node) {
    return frames_of(message(kDronecanEscStatus, node), kDronecanEscStatus.signature, 0, bytes_of(40))[0];
  };
  EXPECT_EQ(receiver.push(first_of(1)), Heard::partial);
  EXPECT_EQ(receiver.push(first_of(2)), Heard::partial);
  EXPECT_EQ(receiver.push(first_of(3)), Heard::broken);
  EXPECT_EQ(receiver.assembler.stats().no_room, 1u);
  EXPECT_EQ(receiver.push(frames_of(message(kDronecanNodeStatus, 5), kDronecanNodeStatus.signature, 0, bytes_of(7))),
            Heard::complete)
      << "one frame needs no place";
  EXPECT_EQ(receiver.push(first_of(3), Time{} + 2001ms), Heard::partial);
  const auto late = frames_of(message(kDronecanEscStatus, 2), kDronecanEscStatus.signature, 0, bytes_of(40));
  EXPECT_EQ(receiver.push(late[1], Time{} + 2002ms), Heard::broken) << "given up meanwhile";
  EXPECT_EQ(receiver.assembler.stats().timed_out, 2u);
}

TEST(Dronecan, SendersThatBreakTheRulesOnlyCount) {
  Receiver receiver;
  const std::uint32_t id = dronecan_can_id(message(kDronecanEscStatus, 9));
  EXPECT_EQ(receiver.push(frame_of(id, {}, msg::kCanExtended)), Heard::broken) << "no tail";
  EXPECT_EQ(receiver.push(frame_of(id, {1, 2, 0x80}, msg::kCanExtended)), Heard::broken)
      << "first of many, and not full";
  EXPECT_EQ(receiver.push(frame_of(id, {1, 2, 0xE0}, msg::kCanExtended)), Heard::broken) << "begins with the toggle";
  const std::uint32_t anonymous = dronecan_can_id(message(kDronecanAllocation, 0));
  EXPECT_EQ(receiver.push(frame_of(anonymous, {1, 2, 3, 4, 5, 6, 7, 0x80}, msg::kCanExtended)), Heard::broken);
  EXPECT_EQ(receiver.assembler.stats().malformed, 4u);
  EXPECT_EQ(receiver.push(frame_of(id, {1, 0x40}, msg::kCanExtended)), Heard::broken) << "end of what never began";
  EXPECT_EQ(receiver.assembler.stats().stray, 1u);
  // Longer than any type: given up, and nothing is written beyond.
  msg::CanFrame frame = frame_of(id, {1, 2, 3, 4, 5, 6, 7, 0x80}, msg::kCanExtended);
  EXPECT_EQ(receiver.push(frame), Heard::partial);
  int partial = 0;
  for (std::uint8_t toggle = 0x20;; toggle ^= 0x20) {
    frame.data[7] = toggle;
    if (receiver.push(frame) != Heard::partial) break;
    ++partial;
  }
  EXPECT_EQ(partial, 54) << "5 + 54 * 7 = 383 bytes";
  EXPECT_EQ(receiver.assembler.stats().malformed, 5u);
}

TEST(Dronecan, WhatIsNotForUsIsForeign) {
  Receiver receiver;
  EXPECT_EQ(receiver.push(frame_of(0x123, {0xC0})), Heard::foreign) << "11 bits";
  EXPECT_EQ(receiver.push(frame_of(0x123, {0xC0}, msg::kCanExtended | msg::kCanFd)), Heard::foreign);
  DronecanWanted other = kDronecanEscStatus;
  other.type = 20000;
  EXPECT_EQ(receiver.push(frames_of(message(other, 9), 0, 0, bytes_of(3))), Heard::foreign);
  DronecanId service;
  service.service = service.request = true, service.type = 1, service.source = 9;
  service.destination = 43;
  EXPECT_EQ(receiver.push(frames_of(service, kDronecanGetNodeInfo.signature, 0, {})), Heard::foreign);
  service.destination = 42;
  EXPECT_EQ(receiver.push(frames_of(service, kDronecanGetNodeInfo.signature, 0, {})), Heard::complete);
}

TEST(Dronecan, AnonymousTransferOfManyFramesIsNotSent) {
  EXPECT_TRUE(frames_of(message(kDronecanAllocation, 0), kDronecanAllocation.signature, 0, bytes_of(8)).empty());
  EXPECT_EQ(frames_of(message(kDronecanAllocation, 0), kDronecanAllocation.signature, 0, bytes_of(7)).size(), 1u);
}

}  // namespace
}  // namespace sinew::wire::dronecan_test
