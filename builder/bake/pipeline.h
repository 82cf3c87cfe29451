#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>

#include <tbb/parallel_pipeline.h>

#include "cairn/status.h"

namespace cairn {

/// TBB orders a pipeline's filters. This says so once more in terms that ThreadSanitizer sees, which knows
/// nothing of TBB: what one turn did is before whatever a later turn does.
class OrderedTurn {
 public:
  explicit OrderedTurn(std::atomic<std::size_t>& order) : order_(order) { step(); }
  ~OrderedTurn() { step(); }
  OrderedTurn(const OrderedTurn&) = delete;
  OrderedTurn& operator=(const OrderedTurn&) = delete;

 private:
  void step() { order_.fetch_add(1, std::memory_order_acq_rel); }
  std::atomic<std::size_t>& order_;
};

/// A bounded pipeline: `work(i)` runs for i = first … count-1 on all threads of the caller's arena, `sink(i,
/// result)` takes the results one by one in the order of i. At most `in_flight` results exist at a time. Ends
/// at the first error, in the order of i, whichever thread came first.
template <class T>
Status run_in_order(std::size_t first, std::size_t count, std::size_t in_flight,
                    const std::function<Result<T>(std::size_t)>& work,
                    const std::function<Status(std::size_t, T&&)>& sink) {
  struct Item {
    std::size_t index;
    std::optional<Result<T>> result;
  };
  std::size_t next = first;
  std::atomic<bool> stopped = false;
  std::atomic<std::size_t> order = 0;
  const OrderedTurn whole(order);
  Status outcome;
  tbb::parallel_pipeline(
      in_flight,
      tbb::make_filter<void, std::shared_ptr<Item>>(
          tbb::filter_mode::serial_in_order,
          [&](tbb::flow_control& control) {
            const OrderedTurn turn(order);
            if (next >= count || stopped) {
              control.stop();
              return std::shared_ptr<Item>();
            }
            return std::make_shared<Item>(Item{next++, std::nullopt});
          }) &
          tbb::make_filter<std::shared_ptr<Item>, std::shared_ptr<Item>>(tbb::filter_mode::parallel,
                                                                         [&](std::shared_ptr<Item> item) {
                                                                           const OrderedTurn turn(order);
                                                                           item->result.emplace(work(item->index));
                                                                           return item;
                                                                         }) &
          tbb::make_filter<std::shared_ptr<Item>, void>(
              tbb::filter_mode::serial_in_order, [&](const std::shared_ptr<Item>& item) {
                const OrderedTurn turn(order);
                if (!outcome.ok()) return;
                outcome = item->result->ok() ? sink(item->index, std::move(item->result->value()))
                                             : Status(item->result->error());
                if (!outcome.ok()) stopped = true;
              }));
  return outcome;
}

}  // namespace cairn
