import sys; sys.path.insert(0,'/work/wt')
from judge import *
def jobs2():
    for f in (.5,1.5,4):
        for w in ("0","----","+-+-"): yield press,("re25-118743",f,w),{}
    for w in ("0","----"): yield hold,("re25-118743",w),dict(dur=1.5)
    for w in ("0","----"): yield hold,("re25-118743",w),dict(load_j=50,hand_b=.5e-3,dur=2.5)
    for w in ("0","----"): yield bounce,("re25-118743",1,w),{}
    for w in ("----","+-+-"): yield hold,("re25-118743",w),dict(force_w=3.2,more=["thermal.start_c=125","thermal.ambient_c=100","thermal.magnet_per_k=-0.0011"],tag=" hot")
    for w in ("0",): yield hold,("gbm2804-100t",w),{}
    for w in ("0","----"): yield press,("ec45-flat-70w",.5,w),{}
if __name__=="__main__":
    J=list(jobs2()); print(call(J[0]),flush=True)
    with Pool(2) as p:
        for r in p.imap(call,J[1:]): print(r,flush=True)
