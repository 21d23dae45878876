#pragma once
// Scratch memory that several owners use one after the other.

#include <functional>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace ugoki {

/// Lends objects of the type T. The object that was returned last is lent first, because the processor's cache probably still contains it.
/// There are as many objects as loans at the same time, at most one per thread if each thread returns its loan before the next.
/// Thread-safe; take() allocates only where no object is free. The pool must outlive its loans.
template <class T>
class LoanPool {
 public:
  explicit LoanPool(std::function<std::unique_ptr<T>()> make) : make_(std::move(make)) {}

  /// Owns an object until the end of its life, then returns it to the pool.
  class Loan {
   public:
    Loan(LoanPool& pool, std::unique_ptr<T> object) : pool_(&pool), object_(std::move(object)) {}
    Loan(const Loan&) = delete;
    Loan& operator=(const Loan&) = delete;
    ~Loan() { pool_->give_back(std::move(object_)); }
    [[nodiscard]] T& operator*() const { return *object_; }

   private:
    LoanPool* pool_;
    std::unique_ptr<T> object_;
  };

  [[nodiscard]] Loan take() {
    {
      const std::lock_guard lock(mutex_);
      if (!free_.empty()) {
        std::unique_ptr<T> object = std::move(free_.back());
        free_.pop_back();
        return {*this, std::move(object)};
      }
    }
    return {*this, make_()};
  }

 private:
  void give_back(std::unique_ptr<T> object) {
    const std::lock_guard lock(mutex_);
    free_.push_back(std::move(object));
  }

  std::function<std::unique_ptr<T>()> make_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<T>> free_;
};

}  // namespace ugoki
