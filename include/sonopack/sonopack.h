#ifndef SONOPACK_SONOPACK_H
#define SONOPACK_SONOPACK_H
/* sonopack: sound in compressed granular packings. All headers of libsonopack. Those of the libraries that stand on it
 * are in folders of their names: study/ (scenes, studies, files), tapped/ (the tapped column of particles). */
#include <sonopack/amplitude.h>
#include <sonopack/chain.h>
#include <sonopack/clusters.h>
#include <sonopack/coda.h>
#include <sonopack/coherent.h>
#include <sonopack/cost.h>
#include <sonopack/design.h>
#include <sonopack/elastic.h>
#include <sonopack/front.h>
#include <sonopack/modes.h>
#include <sonopack/network.h>
#include <sonopack/packing.h>
#include <sonopack/pulse.h>
#include <sonopack/scaling.h>
#include <sonopack/sensitivity.h>
#include <sonopack/signal.h>
#include <sonopack/sparse.h>
#include <sonopack/spectrum.h>
#include <sonopack/status.h>
#include <sonopack/table.h>
#include <sonopack/transport.h>
#include <sonopack/uncertainty.h>
#include <sonopack/units.h>
#include <sonopack/version.h>
#endif
