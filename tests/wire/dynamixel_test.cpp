// The packets in here are the examples of the ROBOTIS e-manual's pages "DYNAMIXEL Protocol 1.0" and "2.0".
#include "wire/servos/dynamixel.hpp"

#include <gtest/gtest.h>

#include "bytes.hpp"

namespace sinew::wire::dynamixel_test {
namespace {

using test::Bytes, test::bytes_of, test::joined;

constexpr DxlVersion kOne = DxlVersion::one, kTwo = DxlVersion::two;

Bytes finished(DxlBuilder packet) {
  const auto b = packet.finish();
  return {b.begin(), b.end()};
}
Bytes two(Bytes behind_header) { return joined({{0xFF, 0xFF, 0xFD, 0x00}, behind_header}); }

/// A packet that outlives its reader.
struct Found {
  std::uint8_t id = 0, code = 0, error = 0;
  Bytes parameters;
};
std::vector<Found> read_all(DxlReader& reader, const Bytes& stream) {
  std::vector<Found> all;
  for (const std::uint8_t b : stream)
    reader.push(b, [&](const DxlPacket& p) {
      all.push_back({p.id, p.code, p.error, {p.parameters.begin(), p.parameters.end()}});
    });
  return all;
}

TEST(Dynamixel, TheCrcIsTheOneOfTheEManual) {
  EXPECT_EQ(dxl_crc(bytes_of("123456789")), 0xFEE8);
  EXPECT_EQ(dxl_crc(two({0x01, 0x07, 0x00, 0x02, 0x00, 0x00, 0x02, 0x00})), 0x5121) << "the page on the CRC";
}

TEST(Dynamixel, InstructionsOfProtocolTwoAreThoseOfTheEManual) {
  EXPECT_EQ(finished(dxl_ping(kTwo, 1)), two({0x01, 0x03, 0x00, 0x01, 0x19, 0x4E}));
  EXPECT_EQ(finished(dxl_ping(kTwo, kDxlBroadcast)), two({0xFE, 0x03, 0x00, 0x01, 0x31, 0x42}));
  EXPECT_EQ(finished(dxl_read(kTwo, 1, 132, 4)), two({0x01, 0x07, 0x00, 0x02, 0x84, 0x00, 0x04, 0x00, 0x1D, 0x15}));
  EXPECT_EQ(finished(dxl_write(kTwo, 1, 116, Bytes{0x00, 0x02, 0x00, 0x00})),
            two({0x01, 0x09, 0x00, 0x03, 0x74, 0x00, 0x00, 0x02, 0x00, 0x00, 0xCA, 0x89}));
  EXPECT_EQ(finished(dxl_reg_write(kTwo, 1, 104, Bytes{0xC8, 0x00, 0x00, 0x00})),
            two({0x01, 0x09, 0x00, 0x04, 0x68, 0x00, 0xC8, 0x00, 0x00, 0x00, 0xAE, 0x8E}));
  EXPECT_EQ(finished(dxl_action(kTwo, 1)), two({0x01, 0x03, 0x00, 0x05, 0x02, 0xCE}));
  EXPECT_EQ(finished(dxl_factory_reset(kTwo, 1, DxlKeep::id)), two({0x01, 0x04, 0x00, 0x06, 0x01, 0xA1, 0xE6}));
  EXPECT_EQ(finished(dxl_reboot(kTwo, 1)), two({0x01, 0x03, 0x00, 0x08, 0x2F, 0x4E}));
  EXPECT_EQ(finished(dxl_clear_turns(1)), two({0x01, 0x08, 0x00, 0x10, 0x01, 0x44, 0x58, 0x4C, 0x22, 0xB1, 0xDC}));
  EXPECT_EQ(finished(dxl_sync_read(kTwo, 132, 4, Bytes{1, 2})),
            two({0xFE, 0x09, 0x00, 0x82, 0x84, 0x00, 0x04, 0x00, 0x01, 0x02, 0xCE, 0xFA}));
  DxlBuilder sync = dxl_sync_write(kTwo, 116, 4);
  sync.byte(1).bytes(Bytes{0x96, 0, 0, 0}).byte(2).bytes(Bytes{0xAA, 0, 0, 0});
  EXPECT_EQ(finished(sync), two({0xFE, 0x11, 0x00, 0x83, 0x74, 0x00, 0x04, 0x00, 0x01, 0x96,
                                 0x00, 0x00, 0x00, 0x02, 0xAA, 0x00, 0x00, 0x00, 0x82, 0x87}));
  EXPECT_EQ(finished(dxl_bulk_read(kTwo, std::array{DxlPlace{1, 144, 2}, DxlPlace{2, 146, 1}})),
            two({0xFE, 0x0D, 0x00, 0x92, 0x01, 0x90, 0x00, 0x02, 0x00, 0x02, 0x92, 0x00, 0x01, 0x00, 0x1A, 0x05}));
  DxlBuilder bulk = dxl_bulk_write();
  dxl_bulk_part(bulk, 1, 32, Bytes{0xA0, 0x00});
  dxl_bulk_part(bulk, 2, 31, Bytes{0x50});
  EXPECT_EQ(finished(bulk), two({0xFE, 0x10, 0x00, 0x93, 0x01, 0x20, 0x00, 0x02, 0x00, 0xA0, 0x00, 0x02, 0x1F, 0x00,
                                 0x01, 0x00, 0x50, 0xB7, 0x68}));
}

TEST(Dynamixel, InstructionsOfProtocolOneAreThoseOfTheEManual) {
  EXPECT_EQ(finished(dxl_ping(kOne, 1)), (Bytes{0xFF, 0xFF, 0x01, 0x02, 0x01, 0xFB}));
  EXPECT_EQ(finished(dxl_read(kOne, 1, 0x2B, 1)), (Bytes{0xFF, 0xFF, 0x01, 0x04, 0x02, 0x2B, 0x01, 0xCC}));
  EXPECT_EQ(finished(dxl_write(kOne, kDxlBroadcast, 3, Bytes{1})),
            (Bytes{0xFF, 0xFF, 0xFE, 0x04, 0x03, 0x03, 0x01, 0xF6}));
  EXPECT_EQ(finished(dxl_write(kOne, 1, 12, Bytes{100, 170})),
            (Bytes{0xFF, 0xFF, 0x01, 0x05, 0x03, 0x0C, 0x64, 0xAA, 0xDC}));
  EXPECT_EQ(finished(dxl_reg_write(kOne, 1, 0x1E, Bytes{0xF4, 0x01})),
            (Bytes{0xFF, 0xFF, 0x01, 0x05, 0x04, 0x1E, 0xF4, 0x01, 0xE2}));
  EXPECT_EQ(finished(dxl_action(kOne, kDxlBroadcast)), (Bytes{0xFF, 0xFF, 0xFE, 0x02, 0x05, 0xFA}));
  EXPECT_EQ(finished(dxl_factory_reset(kOne, 0, DxlKeep::nothing)), (Bytes{0xFF, 0xFF, 0x00, 0x02, 0x06, 0xF7}));
  DxlBuilder sync = dxl_sync_write(kOne, 0x1E, 4);
  sync.byte(0).word(0x0010).word(0x0150).byte(1).word(0x0220).word(0x0360);
  EXPECT_EQ(finished(sync), (Bytes{0xFF, 0xFF, 0xFE, 0x0E, 0x83, 0x1E, 0x04, 0x00, 0x10, 0x00, 0x50, 0x01, 0x01, 0x20,
                                   0x02, 0x60, 0x03, 0x67}));
  EXPECT_EQ(finished(dxl_bulk_read(kOne, std::array{DxlPlace{1, 0x1E, 2}, DxlPlace{2, 0x24, 2}})),
            (Bytes{0xFF, 0xFF, 0xFE, 0x09, 0x92, 0x00, 0x02, 0x01, 0x1E, 0x02, 0x02, 0x24, 0x1D}));
}

TEST(Dynamixel, AnswersAreTakenApart) {
  DxlReader reader(kTwo);
  const Bytes ping = two({0x01, 0x07, 0x00, 0x55, 0x00, 0x06, 0x04, 0x26, 0x65, 0x5D});
  const Bytes position = two({0x02, 0x08, 0x00, 0x55, 0x00, 0x1F, 0x08, 0x00, 0x00, 0xBA, 0xBE});
  const auto found = read_all(reader, joined({ping, position}));
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].id, 1);
  EXPECT_EQ(found[0].code, 0x55);
  EXPECT_EQ(found[0].parameters, (Bytes{0x06, 0x04, 0x26})) << "model 1030, firmware 38";
  EXPECT_EQ(found[1].parameters, (Bytes{0x1F, 0x08, 0x00, 0x00}));

  DxlReader one(kOne);
  const auto old = read_all(one, {0xFF, 0xFF, 0x01, 0x02, 0x24, 0xD8});
  ASSERT_EQ(old.size(), 1u);
  EXPECT_EQ(old[0].error, kDxl1Overload | kDxl1Heat);
}

TEST(Dynamixel, WhatASimulatedServoAnswersIsWhatARealOneDoes) {
  DxlBuilder status = DxlBuilder::status(kTwo, 1, 0);
  status.word(1030).byte(38);
  EXPECT_EQ(finished(status), two({0x01, 0x07, 0x00, 0x55, 0x00, 0x06, 0x04, 0x26, 0x65, 0x5D}));
  DxlBuilder heat = DxlBuilder::status(kOne, 1, 0);
  heat.byte(0x20);
  EXPECT_EQ(finished(heat), (Bytes{0xFF, 0xFF, 0x01, 0x03, 0x00, 0x20, 0xDB}));
}

TEST(Dynamixel, DataThatLooksLikeAHeaderIsStuffed) {
  const Bytes data{0xFF, 0xFF, 0xFD, 0xFD, 0xFF, 0xFF, 0xFD};
  const Bytes packet = finished(dxl_write(kTwo, 1, 116, data));
  EXPECT_EQ(packet.size(), 12 + data.size() + 2) << "one more byte for each header";
  DxlReader reader(kTwo);
  const auto found = read_all(reader, packet);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].parameters, joined({{116, 0}, data}));
}

TEST(Dynamixel, StuffingBeginsWithTheInstruction) {
  // The instruction cannot be FF, but parameters in a row with the length's bytes must not be stuffed: FF is in none.
  const Bytes ids(0xFF - 0x07 + 1, 0xFD);  // a length of 0xFF
  const Bytes packet = finished(dxl_sync_read(kTwo, 0xFFFF, 0xFFFD, ids));
  DxlReader reader(kTwo);
  const auto found = read_all(reader, packet);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].parameters, joined({{0xFF, 0xFF, 0xFD, 0xFF}, ids}));
}

TEST(Dynamixel, OneAnswerToAFastReadHasAPartForEachServo) {
  // Header, FE, length 1 + 2 * (4 + 2); error, id, data, CRC of all so far; and so on.
  Bytes packet = two({0xFE, 0x0D, 0x00, 0x55, 0x00, 0x07, 0x11, 0x22});
  const auto add_crc = [&packet] {
    const std::uint16_t crc = dxl_crc(packet);
    packet.push_back(static_cast<std::uint8_t>(crc));
    packet.push_back(static_cast<std::uint8_t>(crc >> 8));
  };
  add_crc();
  for (const std::uint8_t b : Bytes{0x80, 0x03, 0x33, 0x44}) packet.push_back(b);
  add_crc();
  ASSERT_EQ(packet.size(), dxl_fast_status_bytes(2, 2));
  DxlReader reader(kTwo);
  int parts = 0;
  for (const std::uint8_t b : packet)
    reader.push(b, [&](const DxlPacket& p) {
      DxlFastParts all(p);
      DxlFastPart part;
      ASSERT_TRUE(all.next(2, part));
      EXPECT_EQ(part.id, 7);
      EXPECT_EQ(part.error, 0);
      EXPECT_EQ(part.data[1], 0x22);
      ASSERT_TRUE(all.next(2, part));
      EXPECT_EQ(part.id, 3);
      EXPECT_EQ(part.error, kDxlAlert);
      EXPECT_EQ(part.data[0], 0x33);
      EXPECT_FALSE(all.next(2, part));
      parts += 2;
    });
  EXPECT_EQ(parts, 2);
}

TEST(Dynamixel, NoByteCanBeLostOrChangedUnseen) {
  for (const DxlVersion v : {kOne, kTwo}) {
    const Bytes good = finished(dxl_write(v, 5, 30, Bytes{0x12, 0x34, 0x56}));
    for (std::size_t i = 0; i < good.size(); ++i) {
      Bytes cut = good;
      cut.erase(cut.begin() + static_cast<std::ptrdiff_t>(i));
      DxlReader reader(v);
      auto found = read_all(reader, joined({cut, good, good}));
      reader.gap([&](const DxlPacket& p) {  // a wrong length may have hidden them until the line was silent
        found.push_back({p.id, p.code, p.error, {p.parameters.begin(), p.parameters.end()}});
      });
      ASSERT_EQ(found.size(), 2u) << i;
      for (const Found& f : found) EXPECT_EQ(f.parameters, read_all(reader, good).at(0).parameters) << i;
      for (int bit = 0; bit < 8; ++bit) {
        Bytes changed = good;
        changed[i] = static_cast<std::uint8_t>(changed[i] ^ 1 << bit);
        DxlReader alone(v);
        EXPECT_TRUE(read_all(alone, changed).empty()) << i << "." << bit;
      }
    }
  }
}

TEST(Dynamixel, AfterASilenceWholePacketsBehindAWrongLengthAreFound) {
  for (const DxlVersion v : {kOne, kTwo}) {
    Bytes broken = finished(DxlBuilder::status(v, 4, 0));
    broken[v == kOne ? 3 : 5] = 0x40;
    DxlBuilder next = DxlBuilder::status(v, 5, 0);
    next.byte(7);
    DxlReader reader(v);
    EXPECT_TRUE(read_all(reader, joined({broken, finished(next)})).empty()) << "it may still go on";
    std::vector<int> ids;
    reader.gap([&](const DxlPacket& p) { ids.push_back(p.id); });
    EXPECT_EQ(ids, std::vector<int>{5});
  }
}

TEST(Dynamixel, WhatDoesNotFitIsNoPacket) {
  EXPECT_TRUE(dxl_write(kOne, 1, 0, Bytes(260)).finish().empty());
  EXPECT_TRUE(dxl_write(kTwo, 1, 0, Bytes(1100)).finish().empty());
  EXPECT_TRUE(dxl_read(kOne, 1, 256, 1).finish().empty()) << "1.0 has addresses of one byte";
  EXPECT_FALSE(dxl_write(kOne, 1, 0, Bytes(252)).finish().empty());
  EXPECT_TRUE(dxl_write(kOne, 1, 0, Bytes(253)).finish().empty());
  EXPECT_EQ(dxl_write(kTwo, 1, 0, Bytes(1012)).finish().size(), Dxl2Format::kMaxFrame);
}

TEST(Dynamixel, SizesOnTheLineAreThoseOfThePackets) {
  for (const DxlVersion v : {kOne, kTwo}) {
    EXPECT_EQ(dxl_ping(v, 1).finish().size(), dxl_instruction_bytes(v, 0));
    DxlBuilder status = DxlBuilder::status(v, 1, 0);
    status.bytes(Bytes(10));
    EXPECT_EQ(status.finish().size(), dxl_status_bytes(v, 10));
  }
}

TEST(Dynamixel, InstructionsAndErrorsHaveNames) {
  EXPECT_EQ(to_string(DxlInstruction::fast_sync_read), "fast sync read");
  EXPECT_EQ(to_string(static_cast<DxlInstruction>(0x7F)), "unknown");
  EXPECT_EQ(to_string(DxlError::data_range), "data range");
  EXPECT_EQ(to_string(static_cast<DxlError>(9)), "unknown");
}

}  // namespace
}  // namespace sinew::wire::dynamixel_test
