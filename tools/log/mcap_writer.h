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

/// Writes an MCAP file (https://mcap.dev/spec) front to back: messages in chunks of about 1 MiB
/// compressed with zstd, a message index after each, and a summary with the schemas, channels,
/// chunk indices, metadata indices and statistics; every check sum is given. Memory: one chunk, and
/// about 100 bytes for each chunk written. One thread. Everything throws InputError where the file
/// cannot be written.
///
/// Strings should be UTF-8. Times are nanoseconds.
class McapWriter {
 public:
  using Fields = std::map<std::string, std::string>;

  /// `library` names the program for those who look for the cause of a fault.
  explicit McapWriter(StagedFile* file, std::string_view library);
  ~McapWriter();
  McapWriter(const McapWriter&) = delete;
  McapWriter& operator=(const McapWriter&) = delete;

  /// Identifiers count from 1; more than 65,535 of a kind are an InputError.
  std::uint16_t AddSchema(std::string_view name, std::string_view encoding, std::string_view data);
  std::uint16_t AddChannel(std::uint16_t schema, std::string_view topic,
                           std::string_view message_encoding, const Fields& metadata);
  void Write(std::uint16_t channel, std::uint32_t sequence, std::uint64_t log_time,
             std::uint64_t publish_time, std::string_view data);
  void AddMetadata(std::string_view name, const Fields& fields);
  /// The end of the data, the summary, the footer. Nothing may follow. The file is not committed.
  void Close();

  /// So many bytes of records make a chunk.
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
  std::uint32_t crc_ = 0;  // of what was written since the file's or the summary's start

  std::string chunk_;  // records
  std::string compressed_;
  std::uint64_t chunk_messages_ = 0;
  Times chunk_times_;
  // By channel: time and place in the chunk of each message.
  std::map<std::uint16_t, std::vector<std::pair<std::uint64_t, std::uint64_t>>> chunk_index_;

  // What the summary repeats: records as they are.
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
