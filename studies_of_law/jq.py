import sys; sys.path.insert(0,'/work/wt')
from judge import *
def jobs2():
    for f in (.5,1.5,4):
        for w in ("0","----","+-+-"): yield press,("re25-118743",f,w),{}
    for w in W: yield hold,("re25-118743",w),dict(dur=1.5)
    for w in ("0","----"): yield hold,("re25-118743",w),dict(load_j=50,hand_b=.5e-3,dur=2.5)
    for w in ("0","----"): yield hold,("re25-118743",w),dict(load_j=10,hand_b=.1e-3,dur=2.5)
    for w in W[:4]: yield hold,("gbm2804-100t",w),{}
    for w in W[:3]: yield hold,("ec45-flat-70w",w),{}
    for f in (.5,4):
        yield press,("gbm2804-100t",f,"0"),{}
        yield press,("ec45-flat-70w",f,"----"),{}
    for w in W[:2]: yield press,("re25-118743",1.5,w,10000,1e5),{}
if __name__=="__main__":
    J=list(jobs2()); print(call(J[0]),flush=True)
    with Pool(2) as p:
        for r in p.imap(call,J[1:]): print(r,flush=True)
