#include "engine/threads/triple_buffer.h"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <thread>
#include <vector>

namespace hpdm {
namespace {

/// Torn when its elements differ: long enough that a copy takes many instructions.
struct Block {
  std::array<std::uint64_t, 32> elements{};
};

TEST(TripleBuffer, ReaderSeesTheInitialValueBeforeAnyPublish) {
  TripleBuffer<int> buffer(7);
  EXPECT_FALSE(buffer.Update());
  EXPECT_EQ(buffer.Front(), 7);
}

TEST(TripleBuffer, ReaderGetsTheNewestValueOnce) {
  TripleBuffer<int> buffer;
  for (int value : {1, 2, 3}) {
    buffer.Back() = value;
    buffer.Publish();
  }
  EXPECT_TRUE(buffer.Update());
  EXPECT_EQ(buffer.Front(), 3);
  EXPECT_FALSE(buffer.Update());
  EXPECT_EQ(buffer.Front(), 3);
}

TEST(TripleBuffer, WriterNeverTouchesTheValueInFront) {
  TripleBuffer<int> buffer;
  buffer.Back() = 1;
  buffer.Publish();
  ASSERT_TRUE(buffer.Update());
  for (int value = 2; value < 20; ++value) {
    buffer.Back() = value;
    EXPECT_EQ(buffer.Front(), 1);
    buffer.Publish();
    EXPECT_EQ(buffer.Front(), 1);
  }
}

TEST(TripleBuffer, SlotsKeepTheSizeOfTheInitialArrays) {
  TripleBuffer<std::vector<double>> buffer(std::vector<double>(100));
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(buffer.Back().size(), 100u);
    buffer.Publish();
    buffer.Update();
  }
}

// The writer continues until the reader has seen enough, so that both really run at once; the time
// limit is for a single busy core, where every value seen costs a switch of threads.
TEST(TripleBuffer, MillionsOfExchangesBetweenThreadsAreWholeAndMonotonic) {
  constexpr std::uint64_t kPublished = 4'000'000;
  constexpr std::uint64_t kSeen = 1'000'000;
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(2);
  TripleBuffer<Block> buffer;
  std::atomic<bool> enough = false;
  std::uint64_t published = 0;  // the writer's, until it has been joined
  std::jthread writer([&] {
    while (published < kPublished || !enough.load(std::memory_order_relaxed)) {
      buffer.Back().elements.fill(++published);
      buffer.Publish();
    }
  });
  std::uint64_t last = 0, seen = 0, torn = 0, backwards = 0;
  const auto read_newest = [&] {
    if (!buffer.Update()) return false;
    const Block& block = buffer.Front();
    const std::uint64_t number = block.elements[0];
    for (std::uint64_t element : block.elements) torn += element != number;
    backwards += number <= last;
    last = number;
    ++seen;
    return true;
  };
  while (seen < kSeen && std::chrono::steady_clock::now() < deadline) {
    if (!read_newest()) std::this_thread::yield();
  }
  enough = true;
  writer.join();
  read_newest();
  EXPECT_EQ(torn, 0u);
  EXPECT_EQ(backwards, 0u);
  EXPECT_EQ(last, published) << "the last value published is never lost";
  EXPECT_GE(published, kPublished);
  EXPECT_GT(seen, 100u) << "the threads did not run at once";
}

// The test above reads as fast as it can; here both sides take turns, so that every exchange is
// seen and the slots change hands in both directions each time.
TEST(TripleBuffer, PingPongLosesNothing) {
  constexpr std::uint64_t kRounds = 20'000;
  TripleBuffer<Block> there, back;
  std::jthread echo([&] {
    for (std::uint64_t n = 1; n <= kRounds;) {
      if (!there.Update()) {
        std::this_thread::yield();
        continue;
      }
      back.Back() = there.Front();
      back.Publish();
      n = there.Front().elements[0] + 1;
    }
  });
  std::uint64_t wrong = 0;
  for (std::uint64_t n = 1; n <= kRounds; ++n) {
    there.Back().elements.fill(n);
    there.Publish();
    while (!back.Update()) std::this_thread::yield();
    for (std::uint64_t element : back.Front().elements) wrong += element != n;
  }
  EXPECT_EQ(wrong, 0u);
}

}  // namespace
}  // namespace hpdm
