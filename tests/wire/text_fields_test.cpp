#include "wire/text/text_fields.hpp"

#include <gtest/gtest.h>

namespace sinew::wire::text_fields_test {
namespace {

const UsarLine& read(TextForm form, std::string_view text) {
  static UsarLine line;
  EXPECT_EQ(parse_text(form, text, line), UsarError::none) << text;
  return line;
}

TEST(TextFields, AStateOfTelloIsKeysAndValues) {
  const UsarLine& line =
      read(TextForm::fields, "mid:-1;x:0;mpry:1,2,-3;pitch:-2;tof:10;bat:87;baro:44.12;agz:-999.00;\r\n");
  EXPECT_EQ(line.type, "state");
  EXPECT_EQ(line.count, 8u);
  EXPECT_EQ(usar_number(line.find("pitch").value), -2.0);
  EXPECT_EQ(usar_number(line.find("mpry").value, 2), -3.0);
  EXPECT_EQ(usar_number(line.find("agz").value), -999.0);
}

TEST(TextFields, AnAnswerWithoutAKeyIsAReply) {
  const UsarLine& line = read(TextForm::fields, "ok\r\n");
  EXPECT_EQ(line.type, "reply");
  EXPECT_EQ(line.find("text").value, "ok");
  EXPECT_EQ(usar_number(read(TextForm::fields, "87").find("text").value), 87.0);
}

TEST(TextFields, AStateThatLostPartsOfItIsRefused) {
  static UsarLine line;
  EXPECT_EQ(parse_text(TextForm::fields, "pitch:1;ro", line), UsarError::text);
  EXPECT_EQ(parse_text(TextForm::fields, ":1;", line), UsarError::text);
  EXPECT_EQ(parse_text(TextForm::fields, " \r\n", line), UsarError::empty);
}

TEST(TextFields, WordsHaveTheirTypeInFront) {
  const UsarLine& line = read(TextForm::words, "HEIGHT 1.5 -2\r\n");
  EXPECT_EQ(line.type, "HEIGHT");
  EXPECT_EQ(usar_number(line.find("value").value, 1), -2.0);
  EXPECT_EQ(read(TextForm::words, "READY").count, 0u);
}

}  // namespace
}  // namespace sinew::wire::text_fields_test
