#include "tools/log/mcap_writer.h"

#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <limits>
#include <span>

#include "engine/base/error.h"

namespace hpdm {
namespace {

constexpr std::string_view kMagic("\x89MCAP0\r\n", 8);
constexpr std::string_view kCompression = "zstd";
constexpr int kCompressionLevel = 3;  // zstd's default

enum Opcode : std::uint8_t {
  kHeader = 0x01,
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kMessageIndex = 0x07,
  kChunkIndex = 0x08,
  kStatistics = 0x0B,
  kMetadata = 0x0C,
  kMetadataIndex = 0x0D,
  kSummaryOffset = 0x0E,
  kDataEnd = 0x0F
};

template <typename Integer>
void Put(Integer value, std::string* to) {
  for (std::size_t i = 0; i < sizeof(Integer); ++i) {
    *to += static_cast<char>(static_cast<std::uint64_t>(value) >> 8 * i & 0xFF);
  }
}

/// Appends a string, or bytes, after its length.
void PutText(std::string_view text, std::string* to) {
  Put(static_cast<std::uint32_t>(text.size()), to);
  *to += text;
}

void PutFields(const McapWriter::Fields& fields, std::string* to) {
  std::string entries;
  for (const auto& [key, value] : fields) {
    PutText(key, &entries);
    PutText(value, &entries);
  }
  PutText(entries, to);
}

void PutCounts(const std::map<std::uint16_t, std::uint64_t>& counts, std::string* to) {
  Put(static_cast<std::uint32_t>(counts.size() * 10), to);
  for (const auto& [key, value] : counts) {
    Put(key, to);
    Put(value, to);
  }
}

void PutRecord(std::uint8_t opcode, std::string_view content, std::string* to) {
  Put(opcode, to);
  Put(std::uint64_t{content.size()}, to);
  *to += content;
}

std::uint32_t Crc(std::string_view bytes, std::uint32_t before = 0) {
  return static_cast<std::uint32_t>(
      crc32_z(before, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

std::uint16_t NextNumber(std::uint16_t* count, const char* of) {
  if (*count == std::numeric_limits<std::uint16_t>::max()) {
    throw InputError(std::string("MCAP: more than 65,535 ") + of + "; select some with --channels");
  }
  return ++*count;
}

}  // namespace

void McapWriter::Times::Include(std::uint64_t time, bool is_first) {
  first = is_first ? time : std::min(first, time);
  last = is_first ? time : std::max(last, time);
}

McapWriter::McapWriter(StagedFile* file, std::string_view library)
    : file_(*file), compressor_(ZSTD_createCCtx(), ZSTD_freeCCtx) {
  Emit(kMagic);
  std::string header;
  PutText("", &header);  // no profile
  PutText(library, &header);
  EmitRecord(kHeader, header);
}

McapWriter::~McapWriter() = default;

std::uint16_t McapWriter::AddSchema(std::string_view name, std::string_view encoding,
                                    std::string_view data) {
  const std::uint16_t number = NextNumber(&schema_count_, "types");
  std::string content;
  Put(number, &content);
  PutText(name, &content);
  PutText(encoding, &content);
  PutText(data, &content);
  PutRecord(kSchema, content, &schemas_);
  PutRecord(kSchema, content, &chunk_);
  return number;
}

std::uint16_t McapWriter::AddChannel(std::uint16_t schema, std::string_view topic,
                                     std::string_view message_encoding, const Fields& metadata) {
  const std::uint16_t number = NextNumber(&channel_count_, "channels");
  std::string content;
  Put(number, &content);
  Put(schema, &content);
  PutText(topic, &content);
  PutText(message_encoding, &content);
  PutFields(metadata, &content);
  PutRecord(kChannel, content, &channels_);
  PutRecord(kChannel, content, &chunk_);
  channel_messages_[number] = 0;
  return number;
}

void McapWriter::Write(std::uint16_t channel, std::uint32_t sequence, std::uint64_t log_time,
                       std::uint64_t publish_time, std::string_view data) {
  constexpr std::size_t kFixedBytes = 2 + 4 + 8 + 8;
  chunk_index_[channel].emplace_back(log_time, chunk_.size());
  Put(std::uint8_t{kMessage}, &chunk_);
  Put(std::uint64_t{kFixedBytes + data.size()}, &chunk_);
  Put(channel, &chunk_);
  Put(sequence, &chunk_);
  Put(log_time, &chunk_);
  Put(publish_time, &chunk_);
  chunk_ += data;
  chunk_times_.Include(log_time, chunk_messages_ == 0);
  times_.Include(log_time, message_count_ == 0);
  ++chunk_messages_;
  ++message_count_;
  ++channel_messages_[channel];
  if (chunk_.size() >= kChunkBytes) EndChunk();
}

void McapWriter::EndChunk() {
  if (chunk_.empty()) return;
  compressed_.resize(ZSTD_compressBound(chunk_.size()));
  const std::size_t size =
      ZSTD_compressCCtx(compressor_.get(), compressed_.data(), compressed_.size(), chunk_.data(),
                        chunk_.size(), kCompressionLevel);
  if (ZSTD_isError(size)) throw MachineError(std::string("zstd: ") + ZSTD_getErrorName(size));

  std::string head;
  Put(chunk_times_.first, &head);
  Put(chunk_times_.last, &head);
  Put(std::uint64_t{chunk_.size()}, &head);
  Put(Crc(chunk_), &head);
  PutText(kCompression, &head);
  Put(std::uint64_t{size}, &head);
  std::string begin;
  Put(std::uint8_t{kChunk}, &begin);
  Put(std::uint64_t{head.size() + size}, &begin);
  const std::uint64_t start = position_;
  Emit(begin);
  Emit(head);
  Emit(std::string_view(compressed_).substr(0, size));
  const std::uint64_t end = position_;

  std::map<std::uint16_t, std::uint64_t> index_offsets;
  for (auto& [channel, messages] : chunk_index_) {
    if (messages.empty()) continue;
    index_offsets[channel] = position_;
    std::string content;
    Put(channel, &content);
    Put(static_cast<std::uint32_t>(messages.size() * 16), &content);
    for (const auto& [time, offset] : messages) {
      Put(time, &content);
      Put(offset, &content);
    }
    EmitRecord(kMessageIndex, content);
    messages.clear();
  }

  std::string index;
  Put(chunk_times_.first, &index);
  Put(chunk_times_.last, &index);
  Put(start, &index);
  Put(end - start, &index);
  PutCounts(index_offsets, &index);
  Put(position_ - end, &index);
  PutText(kCompression, &index);
  Put(std::uint64_t{size}, &index);
  Put(std::uint64_t{chunk_.size()}, &index);
  PutRecord(kChunkIndex, index, &chunk_indices_);

  ++chunk_count_;
  chunk_.clear();
  chunk_messages_ = 0;
  chunk_times_ = {};
}

void McapWriter::AddMetadata(std::string_view name, const Fields& fields) {
  EndChunk();  // metadata lies between chunks
  std::string content;
  PutText(name, &content);
  PutFields(fields, &content);
  const std::uint64_t start = position_;
  EmitRecord(kMetadata, content);
  std::string index;
  Put(start, &index);
  Put(position_ - start, &index);
  PutText(name, &index);
  PutRecord(kMetadataIndex, index, &metadata_indices_);
  ++metadata_count_;
}

void McapWriter::Close() {
  EndChunk();
  std::string data_end;
  Put(crc_, &data_end);
  EmitRecord(kDataEnd, data_end);
  EmitSummary();
  Emit(kMagic);
}

void McapWriter::EmitSummary() {
  std::string statistics;
  Put(message_count_, &statistics);
  Put(schema_count_, &statistics);
  Put(std::uint32_t{channel_count_}, &statistics);
  Put(std::uint32_t{0}, &statistics);  // attachments
  Put(metadata_count_, &statistics);
  Put(chunk_count_, &statistics);
  Put(times_.first, &statistics);
  Put(times_.last, &statistics);
  PutCounts(channel_messages_, &statistics);
  std::string statistics_record;
  PutRecord(kStatistics, statistics, &statistics_record);

  crc_ = 0;
  const std::uint64_t summary_start = position_;
  std::string offsets;
  const std::pair<Opcode, std::string_view> groups[] = {{kSchema, schemas_},
                                                        {kChannel, channels_},
                                                        {kStatistics, statistics_record},
                                                        {kChunkIndex, chunk_indices_},
                                                        {kMetadataIndex, metadata_indices_}};
  for (const auto& [opcode, records] : groups) {
    if (records.empty()) continue;
    std::string offset;
    Put(std::uint8_t{opcode}, &offset);
    Put(position_, &offset);
    Put(std::uint64_t{records.size()}, &offset);
    PutRecord(kSummaryOffset, offset, &offsets);
    Emit(records);
  }
  const std::uint64_t offsets_start = position_;
  Emit(offsets);

  constexpr std::size_t kFooterBytes = 8 + 8 + 4;
  std::string footer;
  Put(std::uint8_t{kFooter}, &footer);
  Put(std::uint64_t{kFooterBytes}, &footer);
  Put(summary_start, &footer);
  Put(offsets_start, &footer);
  Put(Crc(footer, crc_), &footer);
  Emit(footer);
}

void McapWriter::Emit(std::string_view bytes) {
  file_.Write(bytes);
  crc_ = Crc(bytes, crc_);
  position_ += bytes.size();
}

void McapWriter::EmitRecord(std::uint8_t opcode, std::string_view content) {
  std::string record;
  PutRecord(opcode, content, &record);
  Emit(record);
}

}  // namespace hpdm
