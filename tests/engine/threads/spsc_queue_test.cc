#include "engine/threads/spsc_queue.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <thread>

namespace hpdm {
namespace {

struct Item {
  std::array<std::uint64_t, 16> elements{};
};

TEST(SpscQueue, KeepsEveryItemInOrder) {
  SpscQueue<int> queue(4);
  int item = 0;
  EXPECT_FALSE(queue.Pop(&item));
  for (int round = 0; round < 10; ++round) {
    for (int i = 0; i < 3; ++i) EXPECT_TRUE(queue.Push(10 * round + i));
    for (int i = 0; i < 3; ++i) {
      ASSERT_TRUE(queue.Pop(&item));
      EXPECT_EQ(item, 10 * round + i);
    }
  }
  EXPECT_FALSE(queue.Pop(&item));
  EXPECT_EQ(queue.Overflows(), 0u);
}

TEST(SpscQueue, RefusesAndCountsWhatDoesNotFit) {
  SpscQueue<int> queue(3);  // rounded up to 4
  for (int i = 0; i < 4; ++i) EXPECT_TRUE(queue.Push(i));
  EXPECT_FALSE(queue.Push(4));
  EXPECT_FALSE(queue.Push(5));
  EXPECT_EQ(queue.Overflows(), 2u);
  int item = -1;
  ASSERT_TRUE(queue.Pop(&item));
  EXPECT_EQ(item, 0) << "an overflow drops the newest, never what is queued";
  EXPECT_TRUE(queue.Push(6));
  for (int expected : {1, 2, 3, 6}) {
    ASSERT_TRUE(queue.Pop(&item));
    EXPECT_EQ(item, expected);
  }
  EXPECT_FALSE(queue.Pop(&item));
}

TEST(SpscQueue, MillionsOfItemsCrossThreadsWholeAndInOrder) {
  constexpr std::uint64_t kItems = 4'000'000;
  SpscQueue<Item> queue(1024);
  std::jthread producer([&] {
    Item item;
    for (std::uint64_t n = 1; n <= kItems; ++n) {
      item.elements.fill(n);
      while (!queue.Push(item)) std::this_thread::yield();
    }
  });
  std::uint64_t torn = 0, out_of_order = 0;
  Item item;
  for (std::uint64_t n = 1; n <= kItems;) {
    if (!queue.Pop(&item)) {
      std::this_thread::yield();
      continue;
    }
    for (std::uint64_t element : item.elements) torn += element != item.elements[0];
    out_of_order += item.elements[0] != n;
    ++n;
  }
  EXPECT_EQ(torn, 0u);
  EXPECT_EQ(out_of_order, 0u);
}

// The producer does not wait, like the haptic loop: items that arrive and items counted as refused
// add up, and those that arrive rise.
TEST(SpscQueue, OverflowsAndArrivalsAddUpBetweenThreads) {
  constexpr std::uint64_t kItems = 1'000'000;
  SpscQueue<std::uint64_t> queue(16);
  std::uint64_t refused = 0;  // the producer's, until it has been joined
  std::uint64_t end_mark_tries = 0;
  std::jthread producer([&] {
    for (std::uint64_t n = 1; n <= kItems; ++n) {
      refused += !queue.Push(n);
      if (n % 16 == 0) std::this_thread::yield();  // lets some through on a single core
    }
    for (; !queue.Push(kItems + 1); ++end_mark_tries) std::this_thread::yield();  // the end mark
  });
  std::uint64_t arrived = 0, last = 0, backwards = 0;
  while (last <= kItems) {
    std::uint64_t n = 0;
    if (!queue.Pop(&n)) {
      std::this_thread::yield();
      continue;
    }
    backwards += n <= last;
    last = n;
    ++arrived;
  }
  producer.join();
  EXPECT_EQ(backwards, 0u);
  EXPECT_EQ(arrived + refused, kItems + 1) << "every number arrived or was refused";
  EXPECT_EQ(queue.Overflows(), refused + end_mark_tries);
}

}  // namespace
}  // namespace hpdm
