#include "record/recover.hpp"

namespace sinew::record {

hal::Status recover(std::unique_ptr<hal::InputFile> from, std::unique_ptr<hal::OutputFile> to, Recovered& result,
                    const ReadLimits& limits) {
  FileProblem why;
  auto reader = Reader::open(std::move(from), why, limits);
  if (!reader) {
    result.problems.push_back(why);
    return hal::Error{hal::Errc::bad_data, "not an MCAP file"};
  }
  auto writer = Writer::open(std::move(to), options_like(*reader));
  if (!writer) return writer.error();
  Reader* const one = reader.get();
  if (auto done = copy({&one, 1}, {}, **writer, result); !done) return done;
  return (*writer)->finish();
}

}  // namespace sinew::record
