#pragma once
// Of net/dds only: includes Cyclone's headers.
#include <span>
#include <string>
#include <vector>

#ifndef DDS_NDEBUG
#define DDS_NDEBUG  // as Debian's library is built: the layout of its structures depends on it
#endif
#include <dds/dds.h>
#include <dds/ddsi/ddsi_serdata.h>

namespace sinew::net {

/// A sample whose content Cyclone does not look into.
struct RawSample : ddsi_serdata {
  RawSample(const ddsi_sertype* of, ddsi_serdata_kind is, std::size_t bytes);
  std::size_t size = 0;            // with CDR's head
  std::vector<unsigned char> cdr;  // and up to 3 bytes more, 0: Cyclone sends whole words
};

/// A type without keys and of any name, whose samples are bytes. Two of one name are the same to Cyclone.
/// Owner:   the topic that is made of it.
ddsi_sertype* make_raw_type(const std::string& name);

/// Owner:   the caller's; dds_writecdr() takes it.
RawSample* make_raw_sample(const ddsi_sertype* type, std::span<const unsigned char> cdr);

}  // namespace sinew::net
