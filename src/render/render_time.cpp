#include "render/render_time.h"

#include <algorithm>
#include <system_error>

namespace kinora::render {

using Clock = std::chrono::steady_clock;

RenderTime::RenderTime(double seconds, const std::atomic<bool>* caller)
    : end_(Clock::now() +
           std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(std::min(seconds, 1e8)))),
      caller_(caller) {
  try {
    watcher_ = std::thread([this] { watch(); });
  } catch (const std::system_error&) {  // look() is all there is
  }
}

RenderTime::~RenderTime() {
  {
    std::lock_guard lock(mutex_);
    isDone_ = true;
  }
  changed_.notify_all();
  if (watcher_.joinable()) watcher_.join();
}

void RenderTime::look() {
  if ((caller_ && caller_->load(std::memory_order_relaxed)) || Clock::now() >= end_) stop_.store(true);
}

// The caller's flag may be raised by a signal, which can wake nobody: it is looked at now and then.
void RenderTime::watch() {
  constexpr std::chrono::milliseconds kStep(20);
  std::unique_lock lock(mutex_);
  while (!isDone_ && !stop_.load(std::memory_order_relaxed)) {
    changed_.wait_until(lock, std::min(end_, Clock::now() + kStep));
    look();
  }
}

}  // namespace kinora::render
