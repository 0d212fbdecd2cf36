import sys; from judge import *
import numpy as np
from wavehaptics.ladder.run import CONTROLLERS
from wavehaptics.trace.columns import Column as C, Word
def contacts(motor,f,w,dur,k0=(),**k):
    s,F,K,h,c=base(motor,w,**k); s+=["hand.path=taps",f"hand.amplitude_rad={F/h}",f"hand.frequency_hz={f}",f"scene.duration_s={dur}",*k0]
    sc=load("held_wall",s); sim=CONTROLLERS["golden"](sc); T=1/sc.controller.tick_hz; n=round(dur/T)
    rows=np.zeros((n,len(C))); sim.advance(rows,np.zeros((n,len(Word)),dtype=np.int64))
    con=rows[:,C.CONTACT]; b=np.r_[0,np.flatnonzero(np.diff(con))+1,n]
    cell=2*math.pi/10000
    P=rows[:,C.TORQUE]*rows[:,C.OMEGA]*T
    print(motor,f,w,"K",K)
    for a,e in zip(b[:-1],b[1:]):
        if con[a] and e-a>200:
            E=P[a:e].sum(); Fm=abs(rows[a:e,C.TORQUE]).max(); xm=rows[a:e,C.X].max()
            mv=(rows[a:e,C.TORQUE]/K+rows[a:e,C.X])/cell
            print(f"  t {a*T:.4f}..{e*T:.4f} x {xm/cell:5.1f}ct F/K {Fm/K/cell:5.1f}ct E/(.5F²/K) {E/(.5*Fm*Fm/K):+.3f}  E/2ct {E/(.5*K*(2*cell)**2):+.2f} moved {mv.min():+.2f} {mv.max():+.2f} xtot {np.ptp(rows[a:e,C.X])/cell:.1f}")
    return rows
if __name__=="__main__":
    for w in ("0","----","+-+-"): contacts("re25-118743",.5,w,4)
    contacts("re25-118743",1.5,"----",2)
