#ifndef TOPOTAG_HOST_STAGE_TIMES_H_
#define TOPOTAG_HOST_STAGE_TIMES_H_

#include "topotag/detector.h"

namespace topotag {

inline void AddTimes(const StageTimes& times, StageTimes* sum) {
  for (const auto time :
       {&StageTimes::threshold, &StageTimes::binarize, &StageTimes::label, &StageTimes::tree,
        &StageTimes::decode, &StageTimes::vertices, &StageTimes::pose, &StageTimes::total}) {
    sum->*time += times.*time;
  }
}

}  // namespace topotag

#endif  // TOPOTAG_HOST_STAGE_TIMES_H_
