// The time that a scene gives its frame (Option "limits" "int rendertime", in minutes), as the flag that the frame's loop
// looks at. Made by Renderer for each render; the command line's --max-time is the caller's own flag.
#pragma once
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>

namespace kinora::render {

class RenderTime {
 public:
  // caller: a flag that stops the frame as well; may be null.
  RenderTime(double seconds, const std::atomic<bool>* caller);
  ~RenderTime();
  RenderTime(const RenderTime&) = delete;
  RenderTime& operator=(const RenderTime&) = delete;

  std::atomic<bool>* stop() { return &stop_; }
  // Raises the flag where it is due; between passes, for a process that may have no more threads.
  void look();

 private:
  void watch();
  const std::chrono::steady_clock::time_point end_;
  const std::atomic<bool>* caller_;
  std::atomic<bool> stop_{false};
  std::mutex mutex_;
  std::condition_variable changed_;
  bool isDone_ = false;
  std::thread watcher_;
};

}  // namespace kinora::render
