#include "lcmtypes/analysis/channel_facts.h"

namespace hpdm {

bool ChannelCounter::Add(const LogEvent& event) {
  const LcmStruct* type = schemas_->Find(event.data);
  if (facts_.messages == 0) {
    facts_.channel = event.channel;
    facts_.type = schemas_->TypeOf(event.data);
    facts_.first_us = event.time_us;
  }
  if (!facts_.known && type != nullptr) {
    facts_.unreadable = facts_.messages;
    facts_.known = true;
    facts_.type = type->name;
    type_ = type;
  }
  ++facts_.messages;
  facts_.bytes += event.data.size();
  facts_.last_us = event.time_us;
  if (!facts_.known) return false;
  MessageOrder order;
  if (type != type_ || !schemas_->Check(*type_, event.data, &order)) {
    ++facts_.unreadable;
    return false;
  }
  if (order.sequence) Count(order);
  return true;
}

void ChannelCounter::Count(const MessageOrder& order) {
  const std::int64_t number = *order.sequence;
  const auto found = sequences_.find(order.instrument);
  if (found == sequences_.end()) {
    if (sequences_.size() < kMaxInstrumentsCounted) {
      sequences_.emplace(order.instrument, Sequence{number, number});
    }
    return;
  }
  Sequence& sequence = found->second;
  // Unsigned, since the distance between two damaged numbers can be as large as the type's range.
  const std::uint64_t step =
      static_cast<std::uint64_t>(number) - static_cast<std::uint64_t>(sequence.previous);
  sequence.previous = number;
  if (number <= sequence.highest) {
    ++facts_.not_rising;
    sequence.run = step == 1 ? sequence.run + 1 : 1;
    if (sequence.run < kRestartRun) return;
  } else {
    const std::uint64_t missing =
        static_cast<std::uint64_t>(number) - static_cast<std::uint64_t>(sequence.highest) - 1;
    facts_.gaps += missing > 0 ? 1 : 0;
    facts_.lost += missing;
  }
  sequence.highest = number;
  sequence.run = 0;
}

}  // namespace hpdm
