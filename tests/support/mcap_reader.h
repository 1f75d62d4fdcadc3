#pragma once

#include <zlib.h>
#include <zstd.h>

#include <cstdint>
#include <map>
#include <set>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace hpdm {

/// A strict reader of MCAP for the tests, written from the specification. Repeated facts must
/// agree, every offset must lead to the object it names, and every checksum must be present and
/// correct. Throws std::runtime_error with the fault.
class McapFile {
 public:
  struct Schema {
    std::string name, encoding, data;
    bool operator==(const Schema&) const = default;
  };
  struct Channel {
    std::uint16_t schema = 0;
    std::string topic, encoding;
    bool operator==(const Channel&) const = default;
  };
  struct Message {
    std::uint16_t channel = 0;
    std::uint32_t sequence = 0;
    std::uint64_t log_time = 0;
    std::uint64_t publish_time = 0;
    std::string data;
  };
  using Fields = std::map<std::string, std::string>;

  explicit McapFile(std::string bytes) : bytes_(std::move(bytes)) {
    Require(bytes_.size() >= 2 * kMagic.size() && bytes_.starts_with(kMagic) &&
                bytes_.ends_with(kMagic),
            "magic");
    ReadData();
    ReadSummary();
  }

  std::map<std::uint16_t, Schema> schemas;
  std::map<std::uint16_t, Channel> channels;
  std::vector<Message> messages;
  std::map<std::string, Fields> metadata;
  std::size_t chunks = 0;
  std::size_t most_chunk_bytes = 0;

 private:
  static constexpr std::string_view kMagic{"\x89MCAP0\r\n", 8};
  static void Require(bool condition, const std::string& what) {
    if (!condition) throw std::runtime_error("MCAP: " + what);
  }
  static std::uint32_t Crc(std::string_view bytes) {
    return static_cast<std::uint32_t>(
        crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
  }

  /// Takes a record's fields one after the other.
  struct Fielded {
    std::string_view rest;

    std::uint64_t Integer(std::size_t size) {
      Require(rest.size() >= size, "a record ends too early");
      std::uint64_t value = 0;
      for (std::size_t i = size; i-- > 0;) value = value << 8 | static_cast<std::uint8_t>(rest[i]);
      rest.remove_prefix(size);
      return value;
    }
    std::uint16_t U16() { return static_cast<std::uint16_t>(Integer(2)); }
    std::uint32_t U32() { return static_cast<std::uint32_t>(Integer(4)); }
    std::uint64_t U64() { return Integer(8); }
    std::string_view Take(std::uint64_t size) {
      Require(size <= rest.size(), "a length beyond its record");
      const std::string_view taken = rest.substr(0, size);
      rest.remove_prefix(size);
      return taken;
    }
    std::string Text() { return std::string(Take(U32())); }
    Fields Texts() {
      Fielded entries{Take(U32())};
      Fields fields;
      while (!entries.rest.empty()) {
        const std::string key = entries.Text();
        Require(fields.emplace(key, entries.Text()).second, "a key twice");
      }
      return fields;
    }
    std::map<std::uint16_t, std::uint64_t> Counts() {
      Fielded entries{Take(U32())};
      std::map<std::uint16_t, std::uint64_t> counts;
      while (!entries.rest.empty()) {
        const std::uint16_t key = entries.U16();
        Require(counts.emplace(key, entries.U64()).second, "a key twice");
      }
      return counts;
    }
    void End() const { Require(rest.empty(), "a record is too long"); }
  };
  struct Record {
    std::uint8_t opcode;
    Fielded fields;
    std::uint64_t start, end;  // in the bytes it was read from
  };
  static Record RecordAt(std::string_view bytes, std::uint64_t at) {
    Require(at <= bytes.size(), "an offset beyond the file");
    Fielded head{bytes.substr(at)};
    const auto opcode = static_cast<std::uint8_t>(head.Integer(1));
    const std::uint64_t length = head.U64();
    return {opcode, {head.Take(length)}, at, at + 9 + length};
  }

  struct ChunkFacts {
    std::uint64_t first = 0, last = 0, end = 0, compressed = 0, uncompressed = 0;
    std::map<std::uint16_t, std::uint64_t> index_offsets;
    std::uint64_t index_end = 0;
  };

  void ReadData() {
    Record record = RecordAt(bytes_, kMagic.size());
    Require(record.opcode == 0x01, "no header");
    record.fields.Text();
    Require(!record.fields.Text().empty(), "no library");
    record.fields.End();
    ChunkFacts* chunk = nullptr;
    while ((record = RecordAt(bytes_, record.end)).opcode != 0x0F) {
      if (record.opcode == 0x06) {
        if (chunk != nullptr) CheckIndexed(*chunk);
        chunk = &chunk_facts_[record.start];
        ReadChunk(record, chunk);
      } else if (record.opcode == 0x07) {
        Require(chunk != nullptr, "an index without a chunk");
        ReadIndex(record, chunk);
      } else if (record.opcode == 0x0C) {
        if (chunk != nullptr) CheckIndexed(*chunk);
        chunk = nullptr;
        const std::string name = record.fields.Text();
        metadata[name] = record.fields.Texts();
        record.fields.End();
        metadata_places_[name] = {record.start, record.end};
      } else {
        Require(false, "an unexpected record in the data");
      }
    }
    if (chunk != nullptr) CheckIndexed(*chunk);
    Require(record.fields.U32() == Crc(std::string_view(bytes_).substr(0, record.start)),
            "check sum of the data");
    record.fields.End();
    data_end_ = record.end;
  }

  void ReadChunk(Record record, ChunkFacts* facts) {
    ++chunks;
    facts->first = record.fields.U64();
    facts->last = record.fields.U64();
    facts->uncompressed = record.fields.U64();
    const std::uint32_t crc = record.fields.U32();
    Require(record.fields.Text() == "zstd", "compression");
    facts->compressed = record.fields.U64();
    const std::string_view compressed = record.fields.Take(facts->compressed);
    record.fields.End();
    facts->end = facts->index_end = record.end;
    Require(facts->uncompressed < 1 << 26, "an uncompressed size beyond the tests'");
    std::string records(facts->uncompressed, '\0');
    const std::size_t size =
        ZSTD_decompress(records.data(), records.size(), compressed.data(), compressed.size());
    Require(!ZSTD_isError(size) && size == records.size(), "size of a chunk");
    Require(crc == Crc(records), "check sum of a chunk");
    most_chunk_bytes = std::max(most_chunk_bytes, records.size());
    unindexed_.clear();
    bool is_first = true;
    std::uint64_t first = 0, last = 0;
    for (std::uint64_t at = 0; at < records.size();) {
      Record inner = RecordAt(records, at);
      at = inner.end;
      if (inner.opcode == 0x03) {
        AddSchema(&inner.fields, &schemas);
      } else if (inner.opcode == 0x04) {
        AddChannel(&inner.fields, &channels);
      } else {
        Require(inner.opcode == 0x05, "an unexpected record in a chunk");
        Message message;
        message.channel = inner.fields.U16();
        message.sequence = inner.fields.U32();
        message.log_time = inner.fields.U64();
        message.publish_time = inner.fields.U64();
        message.data = inner.fields.rest;
        Require(channels.contains(message.channel), "a message before its channel");
        Require(unindexed_[message.channel].emplace(inner.start, message.log_time).second, "");
        first = is_first ? message.log_time : std::min(first, message.log_time);
        last = is_first ? message.log_time : std::max(last, message.log_time);
        is_first = false;
        messages.push_back(message);
      }
    }
    Require(facts->first == first && facts->last == last, "times of a chunk");
  }

  void ReadIndex(Record record, ChunkFacts* facts) {
    const std::uint16_t channel = record.fields.U16();
    Require(facts->index_offsets.emplace(channel, record.start).second, "two indices of a channel");
    facts->index_end = record.end;
    Fielded entries{record.fields.Take(record.fields.U32())};
    record.fields.End();
    std::map<std::uint64_t, std::uint64_t> places;
    while (!entries.rest.empty()) {
      const std::uint64_t time = entries.U64();
      Require(places.emplace(entries.U64(), time).second, "a message indexed twice");
    }
    Require(unindexed_.contains(channel) && unindexed_[channel] == places,
            "an index that is not of the chunk's messages");
    unindexed_.erase(channel);
  }

  void CheckIndexed(const ChunkFacts&) const {
    Require(unindexed_.empty(), "messages without an index");
  }

  static void AddSchema(Fielded* fields, std::map<std::uint16_t, Schema>* to) {
    const std::uint16_t id = fields->U16();
    Require(id != 0, "a schema of number 0");
    Schema schema;
    schema.name = fields->Text();
    schema.encoding = fields->Text();
    schema.data = fields->Text();
    fields->End();
    Require(to->emplace(id, schema).second, "a schema twice");
  }
  void AddChannel(Fielded* fields, std::map<std::uint16_t, Channel>* to) const {
    const std::uint16_t id = fields->U16();
    Channel channel;
    channel.schema = fields->U16();
    channel.topic = fields->Text();
    channel.encoding = fields->Text();
    fields->Texts();
    fields->End();
    Require(schemas.contains(channel.schema), "a channel before its schema");
    Require(to->emplace(id, channel).second, "a channel twice");
  }

  struct Group {
    std::uint64_t start, end;
    bool operator==(const Group&) const = default;
  };
  using Groups = std::map<std::uint8_t, Group>;  // records of one kind, by opcode

  void ReadSummary() {
    constexpr std::uint64_t kFooterBytes = 9 + 20;
    const std::uint64_t footer_start = bytes_.size() - kMagic.size() - kFooterBytes;
    Record footer = RecordAt(bytes_, footer_start);
    Require(footer.opcode == 0x02 && footer.end == bytes_.size() - kMagic.size(), "footer");
    const std::uint64_t start = footer.fields.U64();
    const std::uint64_t offsets_start = footer.fields.U64();
    Require(start == data_end_, "the summary does not follow the data");
    Require(footer.fields.U32() ==
                Crc(std::string_view(bytes_).substr(start, footer_start + 9 + 16 - start)),
            "check sum of the summary");
    CheckOffsets(offsets_start, footer_start, ReadSummaryRecords(start, offsets_start));
  }

  Groups ReadSummaryRecords(std::uint64_t start, std::uint64_t end) const {
    Groups groups;
    std::map<std::uint16_t, Schema> summary_schemas;
    std::map<std::uint16_t, Channel> summary_channels;
    std::set<std::uint64_t> indexed_chunks;
    std::set<std::string> indexed_metadata;
    bool has_statistics = false;
    for (std::uint64_t at = start; at < end;) {
      Record record = RecordAt(bytes_, at);
      const auto [group, is_new] = groups.try_emplace(record.opcode, Group{at, record.end});
      Require(is_new || group->second.end == at, "the summary is not grouped");
      group->second.end = at = record.end;
      if (record.opcode == 0x03) {
        AddSchema(&record.fields, &summary_schemas);
      } else if (record.opcode == 0x04) {
        AddChannel(&record.fields, &summary_channels);
      } else if (record.opcode == 0x08) {
        CheckChunkIndex(&record.fields, &indexed_chunks);
      } else if (record.opcode == 0x0B) {
        Require(summary_channels.size() == channels.size(), "statistics before the channels");
        CheckStatistics(&record.fields);
        has_statistics = true;
      } else {
        Require(record.opcode == 0x0D, "an unexpected record in the summary");
        const std::uint64_t offset = record.fields.U64();
        const std::uint64_t length = record.fields.U64();
        const std::string name = record.fields.Text();
        record.fields.End();
        const auto place = metadata_places_.at(name);
        Require(place.first == offset && place.second == offset + length, "metadata's place");
        indexed_metadata.insert(name);
      }
    }
    Require(summary_schemas == schemas && summary_channels == channels,
            "the summary's repetitions");
    Require(indexed_chunks.size() == chunk_facts_.size(), "chunks without an index");
    Require(indexed_metadata.size() == metadata.size(), "metadata without an index");
    Require(has_statistics, "no statistics");
    return groups;
  }

  void CheckOffsets(std::uint64_t start, std::uint64_t end, Groups groups) const {
    std::uint64_t at = start;
    while (at < end) {
      Record record = RecordAt(bytes_, at);
      at = record.end;
      Require(record.opcode == 0x0E, "an unexpected record among the offsets");
      const auto opcode = static_cast<std::uint8_t>(record.fields.Integer(1));
      const std::uint64_t group_start = record.fields.U64();
      const Group stated = {group_start, group_start + record.fields.U64()};
      record.fields.End();
      Require(groups.contains(opcode) && groups[opcode] == stated, "a group's place");
      groups.erase(opcode);
    }
    Require(at == end && groups.empty(), "groups without an offset");
  }

  void CheckChunkIndex(Fielded* fields, std::set<std::uint64_t>* indexed) const {
    const std::uint64_t first = fields->U64();
    const std::uint64_t last = fields->U64();
    const std::uint64_t start = fields->U64();
    const std::uint64_t length = fields->U64();
    Require(chunk_facts_.contains(start) && indexed->insert(start).second, "a chunk's place");
    const ChunkFacts& facts = chunk_facts_.at(start);
    Require(facts.first == first && facts.last == last && facts.end == start + length,
            "a chunk's times or length");
    Require(fields->Counts() == facts.index_offsets, "places of a chunk's indices");
    Require(fields->U64() == facts.index_end - facts.end, "length of a chunk's indices");
    Require(fields->Text() == "zstd", "compression");
    Require(fields->U64() == facts.compressed && fields->U64() == facts.uncompressed, "sizes");
    fields->End();
  }

  void CheckStatistics(Fielded* fields) const {
    Require(fields->U64() == messages.size(), "number of messages");
    Require(fields->U16() == schemas.size(), "number of schemas");
    Require(fields->U32() == channels.size(), "number of channels");
    Require(fields->U32() == 0, "number of attachments");
    Require(fields->U32() == metadata.size(), "number of metadata");
    Require(fields->U32() == chunk_facts_.size(), "number of chunks");
    std::uint64_t first = messages.empty() ? 0 : messages[0].log_time, last = first;
    std::map<std::uint16_t, std::uint64_t> counts;
    for (const auto& [id, channel] : channels) counts[id] = 0;
    for (const Message& message : messages) {
      first = std::min(first, message.log_time);
      last = std::max(last, message.log_time);
      ++counts[message.channel];
    }
    Require(fields->U64() == first && fields->U64() == last, "times");
    Require(fields->Counts() == counts, "messages of the channels");
    fields->End();
  }

  std::string bytes_;
  std::uint64_t data_end_ = 0;
  std::map<std::uint64_t, ChunkFacts> chunk_facts_;  // by place
  std::map<std::uint16_t, std::map<std::uint64_t, std::uint64_t>> unindexed_;
  std::map<std::string, std::pair<std::uint64_t, std::uint64_t>> metadata_places_;
};

}  // namespace hpdm
