#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "tools/shared/staged_file.h"

struct ZSTD_CCtx_s;

namespace hpdm {

/// Writes an MCAP file (https://mcap.dev/spec) front to back:
///   1. messages in chunks of about 1 MiB, compressed with zstd, each with a message index;
///   2. a summary with schemas, channels, chunk indices, metadata indices and statistics.
/// All check sums are written. Memory: one chunk, and about 100 bytes per chunk written. One
/// thread. Every function throws InputError if the file cannot be written.
///
/// Strings should be UTF-8. Times are nanoseconds.
class McapWriter {
 public:
  using Fields = std::map<std::string, std::string>;

  /// `library` names the program in the file's header.
  explicit McapWriter(StagedFile* file, std::string_view library);
  ~McapWriter();
  McapWriter(const McapWriter&) = delete;
  McapWriter& operator=(const McapWriter&) = delete;

  /// Identifiers count from 1. More than 65,535 of a kind throw InputError.
  std::uint16_t AddSchema(std::string_view name, std::string_view encoding, std::string_view data);
  std::uint16_t AddChannel(std::uint16_t schema, std::string_view topic,
                           std::string_view message_encoding, const Fields& metadata);
  void Write(std::uint16_t channel, std::uint32_t sequence, std::uint64_t log_time,
             std::uint64_t publish_time, std::string_view data);
  void AddMetadata(std::string_view name, const Fields& fields);
  /// Writes the end of the data, the summary and the footer. Call it last. Does not commit the
  /// file.
  void Close();
  /// A chunk ends when its records reach this many bytes.
  static constexpr std::size_t kChunkBytes = 1 << 20;

 private:
  struct Times {
    std::uint64_t first = 0;
    std::uint64_t last = 0;
    void Include(std::uint64_t time, bool is_first);
  };

  void Emit(std::string_view bytes);
  void EmitRecord(std::uint8_t opcode, std::string_view content);
  void EndChunk();
  void EmitSummary();

  StagedFile& file_;
  std::unique_ptr<ZSTD_CCtx_s, std::size_t (*)(ZSTD_CCtx_s*)> compressor_;
  std::uint64_t position_ = 0;
  std::uint32_t crc_ = 0;  // of the bytes since the start of the file or of the summary

  std::string chunk_;  // records
  std::string compressed_;
  std::uint64_t chunk_messages_ = 0;
  Times chunk_times_;
  // By channel: time and offset in the chunk of each message.
  std::map<std::uint16_t, std::vector<std::pair<std::uint64_t, std::uint64_t>>> chunk_index_;

  // Records that the summary repeats.
  std::string schemas_;
  std::string channels_;
  std::string chunk_indices_;
  std::string metadata_indices_;
  std::uint16_t schema_count_ = 0;
  std::uint16_t channel_count_ = 0;
  std::uint32_t chunk_count_ = 0;
  std::uint32_t metadata_count_ = 0;
  std::uint64_t message_count_ = 0;
  Times times_;
  std::map<std::uint16_t, std::uint64_t> channel_messages_;
};

}  // namespace hpdm
