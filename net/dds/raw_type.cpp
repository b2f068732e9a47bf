#include "net/dds/raw_type.hpp"

#include <dds/ddsi/q_radmin.h>

#include <algorithm>
#include <cstring>

// As rmw_cyclonedds does it (src/serdata.cpp), with bytes in place of a message.
namespace sinew::net {

RawSample::RawSample(const ddsi_sertype* of, ddsi_serdata_kind is, std::size_t bytes)
    : ddsi_serdata{}, size(bytes), cdr((bytes + 3) / 4 * 4) {
  ddsi_serdata_init(this, of, is);
}

namespace {

RawSample& raw(ddsi_serdata* d) { return *static_cast<RawSample*>(d); }
const RawSample& raw(const ddsi_serdata* d) { return *static_cast<const RawSample*>(d); }

/// A fragment may repeat bytes of the one before; what would lie outside is left out.
ddsi_serdata* from_fragments(const ddsi_sertype* type, ddsi_serdata_kind kind, const nn_rdata* fragment,
                             std::size_t size) {
  auto* d = new RawSample(type, kind, size);
  std::size_t done = 0;
  for (; fragment != nullptr && done < size; fragment = fragment->nextfrag) {
    const std::size_t end = std::min<std::size_t>(fragment->maxp1, size);
    if (end <= done || fragment->min > done) continue;
    const unsigned char* payload = NN_RMSG_PAYLOADOFF(fragment->rmsg, NN_RDATA_PAYLOAD_OFF(fragment));
    std::memcpy(d->cdr.data() + done, payload + (done - fragment->min), end - done);
    done = end;
  }
  return d;
}

ddsi_serdata* from_pieces(const ddsi_sertype* type, ddsi_serdata_kind kind, ddsrt_msg_iovlen_t count,
                          const ddsrt_iovec_t* pieces, std::size_t size) {
  auto* d = new RawSample(type, kind, size);
  std::size_t done = 0;
  for (ddsrt_msg_iovlen_t i = 0; i < count && done < size; ++i) {
    const std::size_t n = std::min<std::size_t>(pieces[i].iov_len, size - done);
    std::memcpy(d->cdr.data() + done, pieces[i].iov_base, n);
    done += n;
  }
  return d;
}

const ddsi_serdata_ops kSampleOps = {
    .eqkey = [](const ddsi_serdata*, const ddsi_serdata*) { return true; },
    .get_size = [](const ddsi_serdata* d) { return static_cast<std::uint32_t>(raw(d).size); },
    .from_ser = from_fragments,
    .from_ser_iov = from_pieces,
    .from_keyhash = [](const ddsi_sertype* type, const ddsi_keyhash*) -> ddsi_serdata* {
      return new RawSample(type, SDK_KEY, 0);
    },
    // Samples of ours come by make_raw_sample().
    .from_sample = [](const ddsi_sertype*, ddsi_serdata_kind, const void*) -> ddsi_serdata* { return nullptr; },
    .to_ser = [](const ddsi_serdata* d, std::size_t at, std::size_t n,
                 void* to) { std::memcpy(to, raw(d).cdr.data() + at, n); },
    .to_ser_ref = [](const ddsi_serdata* d, std::size_t at, std::size_t n, ddsrt_iovec_t* to) -> ddsi_serdata* {
      to->iov_base = const_cast<unsigned char*>(raw(d).cdr.data()) + at;
      to->iov_len = n;
      return ddsi_serdata_ref(d);
    },
    .to_ser_unref = [](ddsi_serdata* d, const ddsrt_iovec_t*) { ddsi_serdata_unref(d); },
    .to_sample = [](const ddsi_serdata*, void*, void**, void*) { return false; },
    .to_untyped = [](const ddsi_serdata* d) -> ddsi_serdata* {
      auto* key = new RawSample(d->type, SDK_KEY, 0);
      key->type = nullptr;
      return key;
    },
    .untyped_to_sample = [](const ddsi_sertype*, const ddsi_serdata*, void*, void**, void*) { return true; },
    .free = [](ddsi_serdata* d) { delete &raw(d); },
    .print = [](const ddsi_sertype*, const ddsi_serdata* d, char* to, std::size_t room) -> std::size_t {
      return static_cast<std::size_t>(snprintf(to, room, "%zu bytes", raw(d).size));
    },
    .get_keyhash = [](const ddsi_serdata*, ddsi_keyhash* to, bool) { std::memset(to, 0, sizeof *to); },
#ifdef DDS_HAS_SHM  // never switched on
    .get_sample_size = nullptr,
    .from_iox_buffer = nullptr,
#endif
};

const ddsi_sertype_ops kTypeOps = {
    .version = ddsi_sertype_v0,
    .arg = nullptr,
    .free =
        [](ddsi_sertype* type) {
          ddsi_sertype_fini(type);
          delete type;
        },
    .zero_samples = [](const ddsi_sertype*, void*, std::size_t) {},
    .realloc_samples = [](void** to, const ddsi_sertype*, void*, std::size_t, std::size_t) { *to = nullptr; },
    .free_samples = [](const ddsi_sertype*, void**, std::size_t, dds_free_op_t) {},
    .equal = [](const ddsi_sertype*, const ddsi_sertype*) { return true; },
    .hash = [](const ddsi_sertype*) -> std::uint32_t { return 0; },
    // Without a description of the type, types match by their names.
    .type_id = nullptr,
    .type_map = nullptr,
    .type_info = nullptr,
    .derive_sertype = nullptr,
    .get_serialized_size = nullptr,
    .serialize_into = nullptr,
};

}  // namespace

ddsi_sertype* make_raw_type(const std::string& name) {
  auto* type = new ddsi_sertype{};
  ddsi_sertype_init_flags(type, name.c_str(), &kTypeOps, &kSampleOps, DDSI_SERTYPE_FLAG_TOPICKIND_NO_KEY);
  type->allowed_data_representation = DDS_DATA_REPRESENTATION_FLAG_XCDR1;
  return type;
}

RawSample* make_raw_sample(const ddsi_sertype* type, std::span<const unsigned char> cdr) {
  auto* d = new RawSample(type, SDK_DATA, cdr.size());
  std::copy(cdr.begin(), cdr.end(), d->cdr.begin());
  return d;
}

}  // namespace sinew::net
