export PYTHONUNBUFFERED=1 TF_CPP_MIN_LOG_LEVEL=3
python3 -m pip install -q --no-index --no-deps --no-compile --target /tmp/site .whl/gym*.whl .whl/farama*.whl
export PYTHONPATH=.whl/stub:/tmp/site:src:research/pace
nproc; date; S=${1:-60}
XLA_PYTHON_CLIENT_PREALLOCATE=false taskset -c 0,1 python3 research/pace/runs.py screen --parts 0,1 --together 30 --lanes 160 --seconds $S --out $OUT/gpu/screen.csv > $OUT/gpu.log 2>&1 &
for k in $(seq 2 15); do
  JAX_PLATFORMS=cpu CUDA_VISIBLE_DEVICES= OMP_NUM_THREADS=1 taskset -c $k python3 research/pace/runs.py screen --parts $k --together 2 --seconds $S --out /tmp/cpu/$k.csv > /tmp/log$k 2>&1 &
done
wait
date; (for k in $(seq 2 15); do echo == $k; cat /tmp/log$k; done) > $OUT/cpu.log; (for k in $(seq 2 15); do echo "== $k"; cat /tmp/cpu/$k.csv; done) > $OUT/cpu.csv
tail -5 $OUT/gpu.log; tail -c 3000 $OUT/cpu.log
