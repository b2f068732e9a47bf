#pragma once
// A request and its reply. Only for code that answers requests: it shows the JSON library.
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "hal/os.hpp"
#include "hal/result.hpp"
#include "rt/graph.hpp"

namespace sinew::tap {

using Json = nlohmann::ordered_json;

/// Work that goes on after its request was read, and the reply that waits for it.
struct Change {
  rt::Ticket ticket;  // of a change in a mailbox
  Json reply;
  std::optional<std::uint64_t> number{};  // of work elsewhere, in place of the ticket
};

struct Reply {
  Json json;  // incomplete while `change` is set
  std::optional<Change> change{};
  const hal::SharedMemory* memory = nullptr;  // goes along with the reply
  bool garbage = false;                       // the text was no request at all
  // One more member of `json` as text, with its name: a long member is not built as JSON first. So there is only one
  // large block, which may be refused. The JSON library allocates also where it frees, and ends the program when it
  // cannot.
  std::string long_member{};
};

/// {"ok": true} with these members.
Reply good(const Json& members = Json::object());
/// A refusal, as every failed request is answered.
Json refused(hal::Errc code, const std::string& why);
Reply refuse(hal::Errc code, const std::string& why);
/// The refusal of a request whose member is missing or something else than `what`.
Reply needs(const char* member, const char* what);
/// A member that is a text; null when it is missing or something else.
const std::string* text_of(const Json& request, const char* member);

/// In one line; bytes that are not UTF-8 are replaced.
std::string to_text(const Json& json);
std::string to_text(const Reply& reply);

}  // namespace sinew::tap
