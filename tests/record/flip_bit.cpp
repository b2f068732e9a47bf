// usage: record_flip_bit IN OUT TOPIC N BYTE BIT
// Copies a recording, with one bit of the data of the Nth message of a topic flipped; BYTE counts from behind the CDR
// header. For the tests of the whole program: no checksum of the file can know of it.
#include <cstdio>
#include <cstdlib>
#include <string_view>

#include "hal/linux/file.hpp"
#include "rewrite.hpp"

int main(int argc, char** argv) {
  using namespace sinew;
  if (argc != 7) return 2;
  const std::string_view topic = argv[3];
  const long wanted = std::atol(argv[4]), byte = 4 + std::atol(argv[5]), bit = std::atol(argv[6]);
  auto in = hal::open_file(argv[1]);
  auto out = hal::create_file(argv[2]);
  if (!in || !out) return 2;
  record::FileProblem why;
  const auto reader = record::Reader::open(std::move(*in), why);
  if (!reader) return 2;
  auto writer = record::Writer::open(std::move(*out), record::options_like(*reader));
  if (!writer) return 2;
  long n = 0;
  bool flipped = false;
  const bool whole = record::rewrite(*reader, **writer, [&](const record::Message& m, std::vector<std::byte>& data) {
    if (m.channel->topic != topic || ++n != wanted || byte >= static_cast<long>(data.size())) return true;
    data[static_cast<std::size_t>(byte)] ^= std::byte{1} << bit;
    return flipped = true;
  });
  return (*writer)->finish() && whole && flipped ? 0 : 1;
}
