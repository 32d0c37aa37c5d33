#ifndef SONOPACK_SONOPACK_H
#define SONOPACK_SONOPACK_H
/* sonopack: sound in compressed granular packings. All public headers. */
#include <sonopack/chain.h>
#include <sonopack/coherent.h>
#include <sonopack/column.h>
#include <sonopack/counts.h>
#include <sonopack/elastic.h>
#include <sonopack/figure.h>
#include <sonopack/front.h>
#include <sonopack/modes.h>
#include <sonopack/network.h>
#include <sonopack/packing.h>
#include <sonopack/paper.h>
#include <sonopack/plot.h>
#include <sonopack/pulse.h>
#include <sonopack/scaling.h>
#include <sonopack/scene.h>
#include <sonopack/signal.h>
#include <sonopack/spectrum.h>
#include <sonopack/status.h>
#include <sonopack/store.h>
#include <sonopack/study.h>
#include <sonopack/table.h>
#include <sonopack/version.h>
#endif
