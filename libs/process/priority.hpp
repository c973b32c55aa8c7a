// Which threads of a process get a processor first.
#pragma once

#include <sys/resource.h>
#include <unistd.h>

namespace fusion_slam {

// The calling thread gives way to all others that want the processor, those of its own process
// first: on Linux niceness belongs to the thread (sched(7)). Any thread; for good.
inline void give_way() { setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), 10); }

}  // namespace fusion_slam
