#include "record/compression.hpp"

#include <lz4frame.h>
#include <zstd.h>

namespace sinew::record {
namespace {

using hal::Errc;
using hal::Error;

class NoCompressor final : public Compressor {
 public:
  hal::Status compress(std::span<const std::byte> from, Buffer& to) noexcept override {
    to.clear(), to.append(from);
    return {};
  }
};

class Lz4Compressor final : public Compressor {
 public:
  explicit Lz4Compressor(LZ4F_cctx* context) : context_(context) {}
  ~Lz4Compressor() override { LZ4F_freeCompressionContext(context_); }
  Lz4Compressor(const Lz4Compressor&) = delete;
  Lz4Compressor& operator=(const Lz4Compressor&) = delete;
  hal::Status compress(std::span<const std::byte> from, Buffer& to) noexcept override {
    LZ4F_preferences_t preferences{};
    preferences.frameInfo.contentSize = from.size();
    // One block for most chunks, and no larger than needed: readers take memory for a whole block.
    preferences.frameInfo.blockSizeID = from.size() <= (64u << 10)    ? LZ4F_max64KB
                                        : from.size() <= (256u << 10) ? LZ4F_max256KB
                                                                      : LZ4F_max1MB;
    preferences.frameInfo.blockMode = LZ4F_blockIndependent;
    preferences.autoFlush = 1;
    LZ4F_compressOptions_t options{};
    options.stableSrc = 1;  // lz4 need not keep a copy for the next block
    to.resize(LZ4F_compressFrameBound(from.size(), &preferences));
    std::size_t at = 0;
    const auto did = [&](std::size_t size) {
      if (LZ4F_isError(size) != 0) return false;
      at += size;
      return true;
    };
    const auto room = [&] { return to.size() - at; };
    if (!did(LZ4F_compressBegin(context_, to.data(), room(), &preferences)) ||
        !did(LZ4F_compressUpdate(context_, to.data() + at, room(), from.data(), from.size(), &options)) ||
        !did(LZ4F_compressEnd(context_, to.data() + at, room(), &options)))
      return Error{Errc::out_of_memory, "lz4"};  // its only failure on a target of sufficient size
    to.resize(at);
    return {};
  }

 private:
  LZ4F_cctx* context_;
};

class ZstdCompressor final : public Compressor {
 public:
  explicit ZstdCompressor(ZSTD_CCtx* context) : context_(context) {}
  ~ZstdCompressor() override { ZSTD_freeCCtx(context_); }
  ZstdCompressor(const ZstdCompressor&) = delete;
  ZstdCompressor& operator=(const ZstdCompressor&) = delete;
  hal::Status compress(std::span<const std::byte> from, Buffer& to) noexcept override {
    to.resize(ZSTD_compressBound(from.size()));
    const std::size_t size = ZSTD_compress2(context_, to.data(), to.size(), from.data(), from.size());
    if (ZSTD_isError(size) != 0) return Error{Errc::out_of_memory, "zstd"};
    to.resize(size);
    return {};
  }

 private:
  ZSTD_CCtx* context_;
};

}  // namespace

hal::Result<std::unique_ptr<Compressor>> Compressor::make(Compression compression, int level) {
  switch (compression) {
    case Compression::none:
      return std::unique_ptr<Compressor>(new NoCompressor);
    case Compression::lz4: {
      LZ4F_cctx* context = nullptr;
      if (LZ4F_isError(LZ4F_createCompressionContext(&context, LZ4F_VERSION)) != 0)
        return Error{Errc::out_of_memory, "lz4"};
      return std::unique_ptr<Compressor>(new Lz4Compressor(context));
    }
    case Compression::zstd: {
      ZSTD_CCtx* context = ZSTD_createCCtx();
      if (context == nullptr) return Error{Errc::out_of_memory, "zstd"};
      std::unique_ptr<Compressor> compressor(new ZstdCompressor(context));
      if (ZSTD_isError(ZSTD_CCtx_setParameter(context, ZSTD_c_compressionLevel, level)) != 0 || level < 1 || level > 19)
        return Error{Errc::bad_argument, "zstd level: 1 to 19", level};
      return compressor;
    }
  }
  return Error{Errc::bad_argument, "compression: none, lz4 or zstd"};
}

struct Decompressor::State {
  LZ4F_dctx* lz4 = nullptr;
  ZSTD_DCtx* zstd = nullptr;
  ~State() {
    LZ4F_freeDecompressionContext(lz4);
    ZSTD_freeDCtx(zstd);
  }
  hal::Status lz4_frame(std::span<const std::byte> from, std::span<std::byte> to) noexcept {
    if (lz4 == nullptr && LZ4F_isError(LZ4F_createDecompressionContext(&lz4, LZ4F_VERSION)) != 0)
      return Error{Errc::out_of_memory, "lz4"};
    LZ4F_resetDecompressionContext(lz4);
    for (;;) {
      std::size_t wrote = to.size(), read = from.size();
      const std::size_t hint = LZ4F_decompress(lz4, to.data(), &wrote, from.data(), &read, nullptr);
      if (LZ4F_isError(hint) != 0) return Error{Errc::bad_data, "damaged lz4 frame"};
      from = from.subspan(read), to = to.subspan(wrote);
      if (hint == 0) break;  // the frame is complete
      if (read == 0 && wrote == 0) return Error{Errc::bad_data, "lz4 frame and chunk differ in size"};
    }
    if (!to.empty() || !from.empty()) return Error{Errc::bad_data, "lz4 frame and chunk differ in size"};
    return {};
  }
  hal::Status zstd_frame(std::span<const std::byte> from, std::span<std::byte> to) noexcept {
    if (zstd == nullptr) zstd = ZSTD_createDCtx();
    if (zstd == nullptr) return Error{Errc::out_of_memory, "zstd"};
    const std::size_t size = ZSTD_decompressDCtx(zstd, to.data(), to.size(), from.data(), from.size());
    if (ZSTD_isError(size) != 0) return Error{Errc::bad_data, "damaged zstd frame"};
    if (size != to.size()) return Error{Errc::bad_data, "zstd frame and chunk differ in size"};
    return {};
  }
};

Decompressor::Decompressor() : state_(std::make_unique<State>()) {}
Decompressor::~Decompressor() = default;

hal::Status Decompressor::decompress(Compression compression, std::span<const std::byte> from,
                                     std::span<std::byte> to) noexcept {
  switch (compression) {
    case Compression::lz4:
      return state_->lz4_frame(from, to);
    case Compression::zstd:
      return state_->zstd_frame(from, to);
    case Compression::none:
      break;
  }
  if (from.size() != to.size()) return Error{Errc::bad_data, "chunk of two sizes"};
  if (!from.empty()) std::memcpy(to.data(), from.data(), from.size());
  return {};
}

}  // namespace sinew::record
